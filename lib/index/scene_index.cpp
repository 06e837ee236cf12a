#include "index/scene_index.h"

#include <algorithm>

#include "index/classify.h"

namespace vol::index {

IndexVolume index_of_scene(const volume::Volume& volume, const transfer::TransferFunction& transfer,
                           double reference_length, double epsilon, const IndexOptions& options) {
  const Dims& dims = volume.geometry().dims;
  const std::int64_t longest = std::max({dims[0], dims[1], dims[2]});
  int levels = 0;
  while (levels < 4 && (longest >> (levels + 1)) > 0) ++levels;
  SignificanceOptions significance;
  significance.epsilon = epsilon;
  significance.rule = Rule::segment;
  significance.energy_share = 0.99;
  wavelet::DwtOptions dwt;
  dwt.wavelet = "haar";
  dwt.levels = levels;
  return build_index(significant_classified_details(volume, transfer, reference_length,
                                                    options.standard_distance, dwt, significance),
                     volume.geometry(), options);
}

}  // namespace vol::index
