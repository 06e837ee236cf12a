#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/record.h"
#include "render/surfaces.h"

namespace vol::cli {

/// The option group of what add_surfaces() declares.
inline constexpr const char* kSurfacesGroup = "Surfaces in the picture";

/// Surfaces on the command line, among a volume. Target vol_cli_surfaces.
struct SurfaceOptions {
  std::vector<std::string> isovalues, colours,
      opacities;                                          ///< --isovalue, --surface-colour, --surface-opacity
  std::vector<std::filesystem::path> meshes;              ///< --mesh
  std::vector<std::string> mesh_colours, mesh_opacities;  ///< --mesh-colour, --mesh-opacity

  [[nodiscard]] bool any() const { return !isovalues.empty() || !meshes.empty(); }
};

void add_surfaces(CLI::App& app, SurfaceOptions& options);

/// The surfaces as they were asked for, with what they refer to. Refers to the volume, which must live
/// longer.
class SurfaceSet {
 public:
  /// Looks alone: wrong words are answered before anything is read. \throws vol::Error on numbers and colours
  /// that are none, more or fewer looks than one or one a surface, and looks without a surface
  explicit SurfaceSet(const SurfaceOptions& options);

  /// Reads the meshes (phase "read"), notes them among the record's inputs and counts their triangles; warns
  /// of a mesh that has none.
  void load(Record& record);
  /// Prepares all for rays (phase "surfaces"), and splats among them, if there are any.
  void prepare(const volume::Volume& volume, volume::Reconstruction reconstruction,
               const render::Scene& scene, const render::SplatRays* splats, Record& record);
  [[nodiscard]] const render::Surfaces& surfaces() const { return *surfaces_; }

 private:
  std::vector<double> isovalues_;
  std::vector<std::filesystem::path> paths_;
  std::vector<render::SurfaceLook> looks_, mesh_looks_;
  std::vector<std::unique_ptr<const mesh::TriangleMesh>> meshes_;
  std::vector<std::unique_ptr<const render::IsosurfaceRays>> isosurface_rays_;
  std::vector<std::unique_ptr<const mesh::MeshRays>> mesh_rays_;
  std::unique_ptr<render::Surfaces> surfaces_;
};

}  // namespace vol::cli
