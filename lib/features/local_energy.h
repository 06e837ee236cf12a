#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "wavelet/decomposition.h"

namespace vol::features {

struct FeatureOptions {
  double window = 2;          ///< standard deviation of the Gaussian window, voxels; 0: none
  bool approximation = true;  ///< the local mean is a feature too
};

/// What a volume's wavelet transform says around every voxel (Gross, Lippert, Dreger & Koch 1995, section 5):
/// for every detail subband, of level m and d transformed axes, the local amplitude
///   a(x) = sqrt( sum_k w(p_k - x) c[k]^2 / 2^(dm)  /  sum_k w(p_k - x) ),
/// the root mean square of the part of the signal that lies in the subband, and of the approximation the
/// local mean of 2^(-dm/2) c[k]. w is a Gaussian of the window's width. p_k is where the coefficient sits: at
/// the centre of gravity of the square of its analysis filter, so that features do not drift against the
/// volume from level to level. The sums are taken at the p_k and interpolated linearly between them, before
/// the root; coefficients beyond the volume's box, which are not of its data, are left out of them. Beyond
/// the outermost p_k the features are constant.
///
/// Coefficients that are zero because they were rejected count as zeros. Detail below 8 ulp of float of the
/// largest magnitude in the volume is rounding, and counts as zero.
///
/// Values are kept in float, relative: feature f = unit() * at() + offset(f).
class FeatureField {
 public:
  /// Takes the coefficients and frees them subband by subband: 4 bytes a voxel beyond them, no more than one
  /// subband at a time twice. The same bits for any number of threads. \throws vol::Error on a coefficient
  /// that is not finite
  template <class T>
  FeatureField(wavelet::Decomposition<T>&& decomposition, const FeatureOptions& options);

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }  ///< "level1.LLH"
  [[nodiscard]] int size() const { return static_cast<int>(names_.size()); }
  [[nodiscard]] const volume::GridGeometry& geometry() const { return geometry_; }
  [[nodiscard]] double unit() const { return unit_; }
  [[nodiscard]] double offset(int feature) const {
    return grids_[static_cast<std::size_t>(feature)].is_detail ? 0 : offset_;
  }

  /// The features of a voxel; `values` of size().
  void at(std::int64_t i, std::int64_t j, std::int64_t k, std::span<float> values) const;
  /// Those of a row along x, value of feature f at voxel i in values[f nx + i]. The same numbers as at().
  void row(std::int64_t j, std::int64_t k, std::span<float> values) const;

 private:
  struct Tap {
    std::int32_t first = 0, second = 0;  // coefficients between which the voxel lies
    float weight = 0;                    // of the second
  };
  struct Grid {
    bool is_detail = true;
    Dims dims{0, 0, 0};
    Buffer<float> values;
    std::array<std::vector<Tap>, 3> taps;  // of every voxel along each axis
  };
  template <class T>
  [[nodiscard]] Grid smoothed(const wavelet::Decomposition<T>& d, wavelet::Subband<T>& band,
                              double window) const;

  volume::GridGeometry geometry_;
  double unit_ = 1;
  double offset_ = 0;  // of the approximation
  double least_ = 0;   // relative amplitude below which detail is rounding
  std::vector<std::string> names_;
  std::vector<Grid> grids_;
};

/// Where coefficient 0 of a level sits along an axis, in voxels: the centre of gravity of the square of the
/// analysis filter of `levels` steps, low-pass or (the last of them) high-pass. Coefficient k sits 2^levels k
/// further on.
[[nodiscard]] double coefficient_centre(const std::string& wavelet, int levels, bool high_pass);

}  // namespace vol::features
