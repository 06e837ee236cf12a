#include <algorithm>

#include "fourier/slice.h"
#include "fourier/slice_job.h"

namespace vol::fourier {

FastSlicer::FastSlicer(const SliceSource<float>& source, const Filter& filter)
    : source_(source), taps_(filter.taps()) {
  const auto polynomials = filter.polynomials();
  degree_ = polynomials.degree;
  single_.assign(static_cast<std::size_t>((degree_ + 1) * kMostTaps), 0.0f);
  pairs_.assign(static_cast<std::size_t>((degree_ + 1) * 2 * kMostTaps), 0.0f);
  for (int d = 0; d <= degree_; ++d) {
    for (int t = 0; t < taps_; ++t) {
      const auto c = static_cast<float>(polynomials.coefficients[d * taps_ + t]);
      single_[d * kMostTaps + t] = c;
      pairs_[2 * (d * kMostTaps + t)] = c;
      pairs_[2 * (d * kMostTaps + t) + 1] = c;
    }
  }
}

void FastSlicer::line(const ChannelWeights& weights, const SliceLine& line, std::complex<float>* out) const {
  const auto count = static_cast<std::size_t>(line.count);
  std::vector<const float*> fields;
  for (std::size_t f = 0; f < source_.fields(); ++f) fields.push_back(source_.at(f, 0, 0, 0));
  const bool plain = fields.size() == 1 && weights.size() == 1 && weights[0][0] == 1;
  thread_local std::vector<std::complex<float>> values;
  if (!plain) values.resize(count * fields.size());
  std::complex<float>* values_out = plain ? out : values.data();
  SliceJob job{fields.data(),
               static_cast<int>(fields.size()),
               source_.row_stride(),
               source_.slab_stride(),
               taps_,
               degree_,
               single_.data(),
               pairs_.data(),
               {line.start[0], line.start[1], line.start[2]},
               {line.step[0], line.step[1], line.step[2]},
               line.count,
               reinterpret_cast<float*>(values_out)};
  slice_points(job);
  if (plain) return;
  for (std::size_t c = 0; c < weights.size(); ++c) {
    std::complex<float>* channel = out + c * count;
    std::fill_n(channel, count, std::complex<float>(0));
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const auto weight = static_cast<float>(weights[c][f]);
      if (weight == 0) continue;
      for (std::size_t i = 0; i < count; ++i) channel[i] += weight * values[f * count + i];
    }
  }
}

}  // namespace vol::fourier
