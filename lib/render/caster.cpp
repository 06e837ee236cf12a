#include "render/caster.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "render/max_error.h"

namespace vol::render {
namespace {

/// Puts one picture's X-ray into a channel of another's; what was done for it and may be wrong is added.
void add_channel(RenderResult& result, const RenderResult& one, int channel) {
  const auto samples = one.image.channel("samples"), error = one.image.channel("error");
  for (int y = 0; y < one.image.height; ++y) {
    for (int x = 0; x < one.image.width; ++x) {
      result.image.at(x, y, channel) = one.image.at(x, y, channel);
      if (samples) result.image.at(x, y, *samples) += one.image.at(x, y, *samples);
      if (error) {
        float& most = result.image.at(x, y, *error);
        most = std::max(most, one.image.at(x, y, *error));
      }
    }
  }
  result.counts += one.counts;
  result.error_estimate = std::max(result.error_estimate, one.error_estimate);
}

}  // namespace

Caster::Caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
               const CasterOptions& caster)
    : volume_(volume), scene_(scene), options_(options), caster_(caster) {
  if (options.max_error > 0 && (caster.surfaces || caster.labels)) {
    throw Error("a bound on the error is kept without surfaces and labels only");
  }
  const bool plain = caster.surfaces || caster.labels || options.quadrature == Quadrature::reference;
  if (plain || !(caster.packets || options.max_error > 0)) return;
  packet_volume_.emplace(volume, scene.model == Model::composite);
  packet_scene_.emplace(*packet_volume_, scene_, options.max_error > 0 ? within_error(options) : options,
                        caster.index);
  packet_volume_->forget_macrocells();
}

bool Caster::lay_out_in_blocks(volume::Volume& volume) {
  if (&volume != &volume_) throw Error("the volume to lay out in blocks must be the one that is drawn");
  // A bound on the error may need the voxels as they are.
  if (!packet_scene_ || !packet_scene_->in_packets() || options_.max_error > 0) return false;
  volume::Volume* const copy = packet_volume_->converted();
  volume::Volume& native = copy ? *copy : volume;
  if (blocks_ || !fits_blocks(native)) return blocks_.has_value();
  if (copy) volume::visit(volume, [](auto& grid) { grid.voxels = {}; });
  blocks_.emplace(native);
  packet_scene_->read_from(*blocks_);
  return true;
}

RenderResult Caster::cast(image::Image spare) const {
  if (caster_.surfaces) {
    return raycast_with_surfaces(volume_, scene_, options_, *caster_.surfaces, caster_.index, caster_.labels);
  }
  if (caster_.labels) return raycast_plain(volume_, scene_, options_, caster_.index, caster_.labels);
  if (options_.quadrature == Quadrature::reference) return raycast_reference(volume_, scene_, options_);
  if (options_.max_error > 0) return cast_within_error(*packet_scene_, scene_.view);
  if (packet_scene_) return packet_scene_->cast(scene_.view, std::move(spare));
  if (options_.quadrature == Quadrature::split) return raycast_split_plain(volume_, scene_, options_);
  return raycast_plain(volume_, scene_, options_, caster_.index);
}

RenderResult cast_channels(const std::vector<std::unique_ptr<const Caster>>& channels) {
  RenderResult result = channels.at(0)->cast();
  for (std::size_t c = 1; c < channels.size(); ++c) {
    add_channel(result, channels[c]->cast(), static_cast<int>(c));
  }
  return result;
}

}  // namespace vol::render
