#pragma once
#include <cstdint>
#include <limits>

#include "mesh/triangle_mesh.h"
#include "volume/volume.h"

namespace vol::isosurface {

struct MarchingCubesOptions {
  bool close = false;   ///< beyond the volume's border all is outside: the surface is closed there, flat
  bool normals = true;  ///< of the field
  /// Bytes that volume and rows (see below) may take together; more is refused before it is taken.
  std::int64_t memory_limit = std::numeric_limits<std::int64_t>::max();
};

struct MarchingCubesCounts {
  std::int64_t cells = 0;            ///< of the volume
  std::int64_t active_cells = 0;     ///< that the surface passes through
  std::int64_t ambiguous_cells = 0;  ///< of these, with an ambiguous face or several loops
  std::int64_t tubes = 0;            ///< of these, with a tube
};

struct Isosurface {
  mesh::TriangleMesh mesh;
  MarchingCubesCounts counts;
};

/// The isosurface of the trilinear field as a triangle mesh, by marching cubes (Lorensen & Cline 1987) with
/// the topology of the field in every cell (Nielson 2003): ambiguous faces and tubes within cells are decided
/// exactly (saddles.h), f >= isovalue is inside, and a tie is decided alike in all cells. So the mesh is an
/// orientable manifold, closed but for the volume's border, whatever the data: a vertex is its grid edge (or
/// a point within a cell), even where several are at one place because a sample equals the isovalue.
///
/// Vertices: world coordinates, first those on grid edges, row by row (x edges, y edges, z edges of a row of
/// samples), then those within cells. Triangles run counterclockwise as seen from outside, whatever the sign
/// of the volume's axes; normals, -grad f / |grad f| by central differences at the samples (one-sided at the
/// border), interpolated along the edge, point from inside to outside. On a closed border the normal is the
/// border's. An axis of one sample is one spacing thick with the field constant along it.
///
/// The same mesh whatever the number of threads. Takes beside the mesh, of each row of samples along x, a bit
/// a sample in words of 8 bytes and 33 bytes more, and 4 bytes an ambiguous cell. So a volume whose x axis is
/// the short one takes more than its voxels may: 1 x 8192 x 8192 takes 2.2 GB, and is best turned before.
///
/// \throws vol::Error on an isovalue that is not finite, on 2^32 vertices or more, and over memory_limit
[[nodiscard]] Isosurface marching_cubes(const volume::Volume& volume, double isovalue,
                                        const MarchingCubesOptions& options = {});

}  // namespace vol::isosurface
