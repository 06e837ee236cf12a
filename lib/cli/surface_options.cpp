#include "cli/surface_options.h"

#include "base/error.h"
#include "cli/options.h"
#include "io/file.h"
#include "io/mesh.h"

namespace vol::cli {
namespace {

/// One look a surface: of none, one or as many words as there are surfaces.
std::vector<render::SurfaceLook> looks(std::size_t surfaces, const std::string& of,
                                       const std::string& colour_option,
                                       const std::vector<std::string>& colours,
                                       const std::string& opacity_option,
                                       const std::vector<std::string>& opacities) {
  const auto check = [&](const std::string& option, std::size_t n) {
    if (n <= 1 && (n == 0 || surfaces > 0)) return;
    if (n == surfaces) return;
    throw Error(option + ": given " + std::to_string(n) + " times for " + std::to_string(surfaces) + " " +
                of + "; once is for all of them");
  };
  check(colour_option, colours.size());
  check(opacity_option, opacities.size());
  std::vector<render::SurfaceLook> result(surfaces);
  for (std::size_t n = 0; n < surfaces; ++n) {
    if (!colours.empty()) {
      result[n].colour = parse_colour(colour_option, colours[colours.size() == 1 ? 0 : n]);
    }
    if (opacities.empty()) continue;
    const std::string& text = opacities[opacities.size() == 1 ? 0 : n];
    const std::vector<double> value = parse_numbers(opacity_option, {text});
    if (value.size() != 1 || value[0] < 0 || value[0] > 1) {
      throw Error(opacity_option + " " + text + ": expected a number from 0 to 1");
    }
    result[n].opacity = value[0];
  }
  return result;
}

}  // namespace

void add_surfaces(CLI::App& app, SurfaceOptions& o) {
  const auto repeatable = [&](const char* name, auto& values, const char* text, const char* type) {
    return app.add_option(name, values, text)
        ->allow_extra_args(false)
        ->take_all()
        ->type_name(type)
        ->group(kSurfacesGroup);
  };
  repeatable("--isovalue", o.isovalues, "Isosurfaces of these values in the picture, at their exact depth",
             "VALUE,...");
  repeatable("--surface-colour", o.colours,
             "R,G,B of the isosurfaces, linear, 0 to 1; once for all or one each [0.8]", "R,G,B");
  repeatable("--surface-opacity", o.opacities, "0 to 1, of the isosurfaces; once for all or one each [1]",
             "OPACITY");
  repeatable("--mesh", o.meshes,
             "Mesh in the picture, in world coordinates (.ply .obj .stl); several at once", "FILE")
      ->group("Files");
  repeatable("--mesh-colour", o.mesh_colours, "R,G,B of the meshes; once for all or one each [0.8]", "R,G,B");
  repeatable("--mesh-opacity", o.mesh_opacities, "0 to 1, of the meshes; once for all or one each [1]",
             "OPACITY");
}

SurfaceSet::SurfaceSet(const SurfaceOptions& o)
    : isovalues_(parse_numbers("--isovalue", o.isovalues)),
      paths_(o.meshes),
      looks_(looks(isovalues_.size(), "isovalues", "--surface-colour", o.colours, "--surface-opacity",
                   o.opacities)),
      mesh_looks_(looks(paths_.size(), "meshes", "--mesh-colour", o.mesh_colours, "--mesh-opacity",
                        o.mesh_opacities)) {}

void SurfaceSet::load(Record& record) {
  std::int64_t triangles = 0;
  for (const auto& path : paths_) {
    record.input(path);
    meshes_.push_back(record.timed(
        "read", [&] { return std::make_unique<const mesh::TriangleMesh>(io::read_mesh(path)); }));
    const auto count = static_cast<std::int64_t>(meshes_.back()->triangles.size());
    if (count == 0) record.warn(io::display_name(path) + ": no triangles: nothing of it is in the picture");
    record.count("mesh_triangles", triangles += count);
  }
}

void SurfaceSet::prepare(const volume::Volume& volume, volume::Reconstruction reconstruction,
                         const render::Scene& scene, const render::SplatRays* splats, Record& record) {
  record.timed("surfaces", [&] {
    surfaces_ = std::make_unique<render::Surfaces>(scene);
    for (std::size_t n = 0; n < isovalues_.size(); ++n) {
      isosurface_rays_.push_back(
          std::make_unique<const render::IsosurfaceRays>(volume, reconstruction, isovalues_[n], false));
      surfaces_->add(*isosurface_rays_.back(), looks_[n]);
    }
    for (std::size_t n = 0; n < meshes_.size(); ++n) {
      try {
        mesh_rays_.push_back(std::make_unique<const mesh::MeshRays>(*meshes_[n]));
      } catch (const Error& e) {
        throw Error(io::display_name(paths_[n]) + ": " + e.what());
      }
      surfaces_->add(*mesh_rays_.back(), mesh_looks_[n]);
    }
    if (splats != nullptr) surfaces_->add(*splats);
  });
}

}  // namespace vol::cli
