#include "fourier_gpu/gpu_projector.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/timer.h"
#include "fourier_gpu/shaders.h"  // made by the build from the .comp files

namespace vol::fourier_gpu {
namespace {

/// Prime factors, the largest first.
std::vector<int> factors(std::int64_t n) {
  std::vector<int> result;
  std::int64_t rest = n;
  for (const int prime : {7, 5, 3, 2}) {
    for (; rest % prime == 0; rest /= prime) result.push_back(prime);
  }
  if (rest != 1) {
    throw Error("--ifft gpu cannot transform " + std::to_string(n) +
                " pixels, which have a prime factor above 7; " + std::to_string(fourier::next_fast_size(n)) +
                " would do, or --ifft fftw");
  }
  return result;
}

std::vector<float> twiddles(std::int64_t n) {
  std::vector<float> result;
  for (std::int64_t t = 0; t < n; ++t) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(t) / static_cast<double>(n);
    result.push_back(static_cast<float>(std::cos(angle)));
    result.push_back(static_cast<float>(std::sin(angle)));
  }
  return result;
}

gpu::StorageBuffer coefficients_of(const fourier::Filter& filter) {
  const auto polynomials = filter.polynomials();
  const std::vector<float> narrow(polynomials.coefficients.begin(), polynomials.coefficients.end());
  return gpu::StorageBuffer(narrow.size() * sizeof(float), narrow.data());
}

}  // namespace

/// The buffers of one size of slice. Rows are `stride` complex numbers: half of them where FFTW transforms
/// back, all of them where the device does.
struct GpuProjector::Plane {
  std::int64_t stride, rows;
  gpu::StorageBuffer phase_x, phase_y, slice, other, twiddle_x, twiddle_y;
  std::unique_ptr<fourier::SlicePlane<float>> host;

  Plane(std::int64_t width, std::int64_t height, std::size_t channels, InverseBy inverse)
      : stride(inverse == InverseBy::gpu ? width : width / 2 + 1),
        rows(height),
        phase_x(static_cast<std::size_t>(width / 2 + 1) * 8),
        phase_y(static_cast<std::size_t>(height) * 8),
        slice(static_cast<std::size_t>(stride * height) * channels * 8),
        other(inverse == InverseBy::gpu ? slice.bytes() : 8),
        twiddle_x(static_cast<std::size_t>(width) * 8, twiddles(width).data()),
        twiddle_y(static_cast<std::size_t>(height) * 8, twiddles(height).data()) {
    if (inverse == InverseBy::fftw)
      host = std::make_unique<fourier::SlicePlane<float>>(width, height, channels);
  }
};

GpuProjector::GpuProjector(const gpu::Context&, const fourier::SliceSource<float>& source,
                           const fourier::Filter& filter, InverseBy inverse)
    : inverse_(inverse),
      taps_(filter.taps()),
      degree_(filter.polynomials().degree),
      slice_("slice.comp", kSliceShader),
      fft_("fft.comp", kFftShader),
      coefficients_(coefficients_of(filter)) {
  const Dims& m = source.info().padded;
  const std::int64_t margin = source.taps() / 2 + 1, half_y = m[1] / 2 + margin, half_z = m[2] / 2 + margin;
  zero_[0] = static_cast<int>(margin);
  zero_[1] = static_cast<int>(half_y);
  zero_[2] = static_cast<int>(half_z);
  for (std::size_t f = 0; f < source.fields(); ++f) {
    fields_.emplace_back(source.row_stride() / 2, 2 * half_y + 1, 2 * half_z + 1,
                         source.at(f, -margin, -half_y, -half_z));
  }
}

GpuProjector::~GpuProjector() = default;

const gpu::StorageBuffer* GpuProjector::transform(const Plane& plane, bool along_y, std::int64_t n,
                                                  std::int64_t lines, const gpu::StorageBuffer* first,
                                                  const gpu::StorageBuffer* second) const {
  (along_y ? plane.twiddle_y : plane.twiddle_x).bind(0);
  fft_.set("n", static_cast<int>(n));
  fft_.set("lines", static_cast<int>(lines));
  fft_.set("step", static_cast<int>(along_y ? plane.stride : 1));
  fft_.set("line_step", static_cast<int>(along_y ? 1 : plane.stride));
  fft_.set("first_element", 0);
  std::int64_t done = 1;
  for (const int radix : factors(n)) {
    first->bind(1);
    second->bind(2);
    fft_.set("hermitian", !along_y && done == 1 ? 1 : 0);
    fft_.set("s", static_cast<int>(done));
    fft_.set("radix", radix);
    fft_.run(n / radix, lines);
    done *= radix;
    std::swap(first, second);
  }
  return first;
}

std::vector<Buffer<float>> GpuProjector::project(const fourier::SliceView& view,
                                                 const fourier::ChannelWeights& weights) {
  if (inverse_ == InverseBy::gpu) {
    (void)factors(view.width);
    (void)factors(view.height);
  }
  const Timer timer;
  // A channel at a time, so that the transform's lines are those of one picture.
  const std::tuple key{view.width, view.height, std::size_t{1}};
  if (!planes_.contains(key)) {
    // Of both kinds the plane on the device and the other one, there or here, are at most this.
    const std::int64_t bytes = 4 * fourier::SlicePlane<float>::bytes(view.width, view.height, 1);
    if (kept_ + bytes > fourier::kKeptPlanes) {
      planes_.clear();
      kept_ = 0;
    }
    planes_[key] = std::make_unique<Plane>(view.width, view.height, 1, inverse_);
    kept_ += bytes;
  }
  const auto& slot = planes_[key];
  Plane& plane = *slot;
  const auto phase_x = fourier::centring_phases<float>(view.width / 2 + 1, view.centre_x, view.width);
  const auto phase_y = fourier::centring_phases<float>(view.height, view.centre_y, view.height);
  plane.phase_x.write(phase_x.data(), phase_x.size() * 8);
  plane.phase_y.write(phase_y.data(), phase_y.size() * 8);
  slice_.set("width", static_cast<int>(view.width));
  slice_.set("height", static_cast<int>(view.height));
  slice_.set("stride", static_cast<int>(plane.stride));
  slice_.set("first_element", 0);
  slice_.set("taps", taps_);
  slice_.set("degree", degree_);
  slice_.set("per_x", {view.per_x[0], view.per_x[1], view.per_x[2]});
  slice_.set("per_y", {view.per_y[0], view.per_y[1], view.per_y[2]});
  slice_.set("nyquist", {view.nyquist[0], view.nyquist[1], view.nyquist[2]});
  slice_.set("zero", zero_);
  times_.slice += timer.seconds();

  std::vector<Buffer<float>> pictures;
  for (const auto& channel : weights) {
    const Timer slice_timer;
    coefficients_.bind(0);
    plane.phase_x.bind(1);
    plane.phase_y.bind(2);
    plane.slice.bind(3);
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      if (f > 0 && channel[f] == 0) continue;
      fields_[f].bind(0);
      slice_.set("weight", static_cast<float>(channel[f]));
      slice_.set("accumulate", f > 0 ? 1 : 0);
      slice_.run(view.width / 2 + 1, view.height);
    }
    gpu::finish();
    gpu::require_no_error("the slice");
    times_.slice += slice_timer.seconds();
    if (inverse_ == InverseBy::fftw) {
      const Timer read_timer;
      std::vector<float> half(static_cast<std::size_t>(2 * plane.stride * view.height));
      plane.slice.read(half.data(), half.size() * sizeof(float));
      const std::int64_t columns = plane.host->columns(view);
      for (std::int64_t q = 0; q < view.height; ++q) {
        const std::int64_t count = 2 * std::min(columns, plane.stride);
        float* row = plane.host->row(0, q);
        std::copy_n(half.data() + 2 * plane.stride * q, count, row);
        std::fill(row + count, row + 2 * columns, 0.0f);
      }
      times_.read_back += read_timer.seconds();
      const Timer inverse_timer;
      std::vector<Buffer<float>> one;
      plane.host->pictures(view, columns, one);
      pictures.push_back(std::move(one[0]));
      times_.inverse += inverse_timer.seconds();
      continue;
    }
    const Timer inverse_timer;
    const auto* columns = transform(plane, true, view.height, view.width / 2 + 1, &plane.slice, &plane.other);
    const auto* result = transform(plane, false, view.width, view.height, columns,
                                   columns == &plane.slice ? &plane.other : &plane.slice);
    gpu::finish();
    gpu::require_no_error("the inverse transform");
    times_.inverse += inverse_timer.seconds();
    const Timer read_timer;
    std::vector<float> all(static_cast<std::size_t>(2 * plane.stride * view.height));
    result->read(all.data(), all.size() * sizeof(float));
    Buffer<float> picture(static_cast<std::size_t>(view.picture_width * view.picture_height));
    const std::int64_t skip_x = (view.width - view.picture_width) / 2,
                       skip_y = (view.height - view.picture_height) / 2;
    const auto scale = static_cast<float>(view.scale);
    for (std::int64_t y = 0; y < view.picture_height; ++y) {
      const float* row = all.data() + 2 * (plane.stride * (y + skip_y) + skip_x);
      for (std::int64_t x = 0; x < view.picture_width; ++x) {
        picture[static_cast<std::size_t>(y * view.picture_width + x)] = row[2 * x] * scale;
      }
    }
    pictures.push_back(std::move(picture));
    times_.read_back += read_timer.seconds();
  }
  return pictures;
}

}  // namespace vol::fourier_gpu
