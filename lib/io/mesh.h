#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mesh/triangle_mesh.h"

namespace vol::io {

/// A run of a mesh's vertices and triangles that belongs to one isovalue or label; runs follow one another.
struct MeshPart {
  double value = 0;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

struct MeshWriteOptions {
  std::string format = {};           ///< "ply", "obj" or "stl"; empty: by extension, ply for standard output
  bool double_precision = false;     ///< positions as f64 (ply, obj); else f32
  std::vector<MeshPart> parts = {};  ///< where there are several: ply has a property of this name, obj groups
  std::string part_name = "isovalue";
  std::map<std::string, std::string> attributes = {};  ///< become comments (ply, obj)
};

/// Writes a mesh as PLY (binary, little endian), Wavefront OBJ (text, the shortest digits that read back the
/// same) or STL (binary: triangles alone, f32). The same mesh gives the same bytes; the file appears whole or
/// not at all. `-` is standard output.
///
/// \return what the format could not hold, one sentence each
/// \throws vol::Error on another format, double precision for STL, too many triangles for it, and files that
/// cannot be written
std::vector<std::string> write_mesh(const std::filesystem::path& path, const mesh::TriangleMesh& mesh,
                                    const MeshWriteOptions& options = {});

/// Throws what write_mesh would throw for the name and options alone: call it before the work, not after.
/// \return the format that will be written: ply, obj or stl
std::string require_mesh_format(const std::filesystem::path& path, const MeshWriteOptions& options);

/// Reads a mesh: PLY (ascii, or binary of either byte order), Wavefront OBJ or STL (ascii or binary), by what
/// the file begins with and its extension. Polygons become fans of triangles about their first corner, which
/// fits convex ones. Normals are those of PLY's vertices, and of OBJ where every corner's normal has its
/// vertex's number, made unit; STL's are left out, and its corners stay three vertices a triangle. Colours,
/// texture and other elements are passed over. A file of neither vertices nor faces is an empty mesh. `-` is
/// standard input, for PLY alone.
///
/// \throws vol::Error naming the file: what is none of these, ends early, has vertices and no face, or has a
/// vertex that does not exist or a coordinate that is not finite
[[nodiscard]] mesh::TriangleMesh read_mesh(const std::filesystem::path& path);

}  // namespace vol::io
