#include "render/grid_field.h"

#include "volume/grid_sampler.h"

namespace vol::render {

GridField::GridField(const volume::Volume& volume, volume::Reconstruction reconstruction) {
  volume::visit(volume, [&](const auto& grid) {
    using T = typename std::decay_t<decltype(grid)>::value_type;
    const auto keep = [&]<volume::Reconstruction kKernel>() {
      const auto sampler = std::make_shared<const volume::GridSampler<T, kKernel>>(grid);
      view_ = view_of(*sampler);
      sampler_ = sampler;
    };
    using enum volume::Reconstruction;
    switch (reconstruction) {
      case nearest:
        return keep.template operator()<nearest>();
      case trilinear:
        return keep.template operator()<trilinear>();
      case catmull_rom:
        return keep.template operator()<catmull_rom>();
      case b_spline:
        return keep.template operator()<b_spline>();
    }
  });
}

}  // namespace vol::render
