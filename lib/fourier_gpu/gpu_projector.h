#pragma once
#include <map>
#include <memory>
#include <tuple>

#include "fourier/projection.h"
#include "gpu/context.h"

namespace vol::fourier_gpu {

/// Where the slice is transformed back: by FFTW on the CPU, or by the device.
enum class InverseBy { fftw, gpu };

/// Projector<float> on a device: spectra in 3D textures, the filters by texelFetch and the same polynomials,
/// positions in double as on the CPU. Textures, plans and buffers are kept from picture to picture.
class GpuProjector {
 public:
  /// The context must be current and live longer. The source is copied to the device.
  GpuProjector(const gpu::Context& context, const fourier::SliceSource<float>& source,
               const fourier::Filter& filter, InverseBy inverse);
  ~GpuProjector();

  /// Seconds that project() has taken so far.
  struct Times {
    double slice = 0, inverse = 0, read_back = 0;
  };
  [[nodiscard]] const Times& times() const { return times_; }

  /// One plane a row of `weights`. \throws vol::Error where the device is to transform back a size with a
  /// prime factor above 7
  [[nodiscard]] std::vector<Buffer<float>> project(const fourier::SliceView& view,
                                                   const fourier::ChannelWeights& weights);

 private:
  struct Plane;
  InverseBy inverse_;
  int taps_, degree_, zero_[3];
  gpu::ComputeProgram slice_, fft_;
  std::vector<gpu::PairTexture> fields_;
  gpu::StorageBuffer coefficients_;
  std::map<std::tuple<std::int64_t, std::int64_t, std::size_t>, std::unique_ptr<Plane>> planes_;
  std::int64_t kept_ = 0;  // bytes of planes_
  Times times_;

  /// Inverse transforms along lines, `first` and `second` in turn; returns the one that holds the result.
  const gpu::StorageBuffer* transform(const Plane& plane, bool along_y, std::int64_t n, std::int64_t lines,
                                      const gpu::StorageBuffer* first,
                                      const gpu::StorageBuffer* second) const;
};

}  // namespace vol::fourier_gpu
