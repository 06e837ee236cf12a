#pragma once
#include <cstdint>
#include <vector>

#include "mesh/mesh_rays.h"
#include "render/isosurface_rays.h"
#include "render/options.h"
#include "render/picture.h"
#include "render/shading.h"
#include "render/splat_rays.h"

namespace vol::render {

/// What a surface shows: its colour before it is lit, and what share of the light behind it it takes.
struct SurfaceLook {
  Vec3 colour{0.8, 0.8, 0.8};
  double opacity = 1;
};

/// Where a ray meets a surface: of no thickness, it adds T opacity colour and leaves T (1 - opacity).
struct SurfaceHit {
  double t = 0;
  Vec3 colour = Vec3::Zero();  ///< lit
  double opacity = 1;
  std::uint32_t surface = 0;  ///< its number: of those at the same t, the lower one is in front
};

/// The surfaces in a picture: isosurfaces of the volume, meshes and splats, lit by Blinn-Phong from both
/// sides with the scene's shading, or with the defaults where the scene has none. All of them must live
/// longer.
class Surfaces {
 public:
  /// \throws vol::Error on a model that is not `composite`, and shading that is none
  explicit Surfaces(const Scene& scene);

  /// \throws vol::Error on a colour or opacity beyond 0 to 1
  void add(const IsosurfaceRays& isosurface, const SurfaceLook& look);
  void add(const mesh::MeshRays& mesh, const SurfaceLook& look);
  /// Opaque, in the colours of its labels.
  void add(const SplatRays& splats);

  /// What a ray meets, front to back up to the first that is opaque. Isosurfaces on the chord, each where its
  /// side changes; meshes and splats wherever the camera sees.
  /// \param chord  in the volume; nullptr where the ray misses it
  void find(const camera::Ray& ray, const Chord* chord, std::vector<SurfaceHit>& hits,
            RenderCounts& counts) const;

  /// Upper bound of a lit colour's components.
  [[nodiscard]] double brightest() const { return brightest_; }

 private:
  template <class Rays>
  struct Surface {
    const Rays* rays;
    SurfaceLook look;
    std::uint32_t number;
  };
  void admit(const SurfaceLook& look);

  BlinnPhong light_;
  double t_min_;
  double brightest_ = 0;
  std::uint32_t next_ = 0;
  std::vector<Surface<IsosurfaceRays>> isosurfaces_;
  std::vector<Surface<mesh::MeshRays>> meshes_;
  std::vector<Surface<SplatRays>> splats_;
};

/// A picture of the volume and of the surfaces in it and around it, in double precision. The chord is cut at
/// every hit's depth and each part is integrated for itself, so that the quadrature keeps its order on either
/// side: the plain caster's steps begin anew behind each hit; `reference` keeps its tolerance for the whole
/// ray, and `split` is as raycast_split_plain. `depth` is where T falls to 0.5, in the medium or at a
/// surface. With labels the medium is theirs. \throws vol::Error as raycast_plain and raycast_reference do,
/// and on a model that is not `composite`
[[nodiscard]] RenderResult raycast_with_surfaces(const volume::Volume& volume, const Scene& scene,
                                                 const RenderOptions& options, const Surfaces& surfaces,
                                                 const index::IndexVolume* index = nullptr,
                                                 const LabelledMedium* labels = nullptr);
/// The same of a field in closed form, whose isosurfaces only meshes can stand for.
[[nodiscard]] RenderResult raycast_with_surfaces(const FieldView& field, const Scene& scene,
                                                 const RenderOptions& options, const Surfaces& surfaces);

/// What raycast_with_surfaces does to a ray; `chord` may be nullptr.
using HybridCaster = std::function<Pixel(const camera::Ray&, const Chord*, RenderCounts&)>;
[[nodiscard]] HybridCaster hybrid_caster(const volume::Volume& volume, const Scene& scene,
                                         const RenderOptions& options, const Surfaces& surfaces,
                                         const index::IndexVolume* index = nullptr,
                                         const LabelledMedium* labels = nullptr);
[[nodiscard]] HybridCaster hybrid_caster(const FieldView& field, const Scene& scene,
                                         const RenderOptions& options, const Surfaces& surfaces);

}  // namespace vol::render
