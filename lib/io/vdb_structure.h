#pragma once
#include <cstddef>
#include <span>

namespace vol::io {

/// Walks an OpenVDB file from its first to its last byte and throws vol::Error unless every length in it is
/// one that OpenVDB's own reader can be trusted with. That reader takes the lengths of strings, metadata and
/// uncompressed chunks at their word and writes past its buffers where they lie (OpenVDB 10.0:
/// bloscFromStream and unzipFromStream read as many bytes as a chunk states, then compare).
///
/// Walked are files of format 222 (2013) to 224 with grids of the standard tree (5, 4, 3) of float, double,
/// int and vector values, half precision included, under linear transforms: whatever else is refused by name.
/// Metadata of types that need no understanding here are renamed in place to a type that OpenVDB does not
/// know and so keeps as bytes.
void check_vdb_structure(std::span<std::byte> file);

}  // namespace vol::io
