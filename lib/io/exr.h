#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "image/image.h"

namespace vol::io {

class InputFile;

/// Reads a flat, single-part OpenEXR image, scan lines or tiles (the full level), any compression; `-` is
/// standard input. Channels come back as R, G, B, A, then the others in the file's order; HALF is widened to
/// float exactly, UINT is refused where float cannot hold it. String attributes come along, others do not.
///
/// Refuses, in one line: what is not OpenEXR, truncated or garbled files, sizes that the file cannot hold
/// (before memory is taken), deep data, several parts, subsampled channels, and a data window that is not
/// the display window. Chunks are decoded on the process's threads. Throws vol::Error naming the file.
[[nodiscard]] image::Image read_exr(const std::filesystem::path& path);
[[nodiscard]] image::Image read_exr(InputFile& file);
/// The same of a file already in memory; `name` is what messages call it.
[[nodiscard]] image::Image decode_exr(std::span<const std::byte> file, const std::string& name);

/// Writes all channels as 32-bit float, bit for bit, zip-compressed, and the attributes as string attributes.
/// No date nor host goes in: the same image gives the same bytes. `-` is standard output. The file appears
/// whole or not at all. Throws vol::Error, also where an attribute would shadow one of the format's own.
void write_exr(const std::filesystem::path& path, const image::Image& image);

}  // namespace vol::io
