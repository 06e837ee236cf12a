#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "wavelet/decomposition.h"

namespace vol::wavelet {

/// How a coefficient c of level m (the finest 1) is weighed against the others. d is the number of axes that
/// are transformed (3, unless an axis has one sample), s the number of those along which the basis function
/// is a scaling function.
///   gross      2^(s/2 + d m/2) |c|   (Gross, Lippert, Dreger & Koch 1995, section 3.1)
///   muraki     2^(d m) |c|           (8^m |c| in three dimensions: Muraki 1993)
///   energy     c^2                   (Gross et al., eq. 25-27: orthonormal basis functions)
///   amplitude  2^(-d m/2) |c|        on the scale of the data
enum class Significance { gross, muraki, energy, amplitude };

[[nodiscard]] std::string_view name(Significance significance);
/// Throws vol::Error listing the names.
[[nodiscard]] Significance significance_from_name(std::string_view name);

/// Significance over |c| (over c^2 for energy) of a subband's coefficients.
[[nodiscard]] double significance_weight(Significance significance, int level, int orientation,
                                         const Dims& extended);

/// Half-open box of voxel indices.
struct VoxelBox {
  std::array<std::int64_t, 3> lower{0, 0, 0};
  std::array<std::int64_t, 3> upper{0, 0, 0};
};

/// Which coefficients stay. At most one of keep, keep_energy and threshold; none of them keeps all.
struct Rejection {
  Significance significance = Significance::energy;
  std::optional<std::int64_t> keep = {};  ///< the N most significant
  std::optional<double> keep_energy =
      {};                                ///< the most significant that hold this share of sum c^2, in [0, 1]
  std::optional<double> threshold = {};  ///< those of at least this significance
  /// Coefficients whose synthesis support meets the box are all kept, whatever the criterion says. Outside,
  /// the criterion decides; without one only the approximation is kept.
  std::optional<VoxelBox> region = {};

  [[nodiscard]] bool any() const { return keep || keep_energy || threshold || region; }
};

/// What rejection did and what it costs. Norms are root sums of squares over the extended box, scaled before
/// squaring, so that 1e200 and 1e-200 come out right.
struct RejectionReport {
  std::int64_t total = 0;    ///< coefficients of the transform
  std::int64_t nonzero = 0;  ///< of them not zero beforehand
  std::int64_t kept = 0;     ///< not zero and not rejected: what is stored
  double norm = 0;           ///< l2 norm of all coefficients
  double rejected_norm = 0;  ///< l2 norm of the rejected ones
};

/// Sets what is rejected to zero. Coefficients that are zero count as rejected from the start. Ties in
/// significance go to the coarser level, the lower orientation, the earlier position.
/// Throws vol::Error on a criterion outside its range or an empty region.
template <class T>
RejectionReport reject(Decomposition<T>& decomposition, const Rejection& rejection);

/// What is known of the L2 error of the rebuilt volume (Gross et al., eq. 25 and 27), rounding apart.
///   exact     periodic, orthonormal, nothing cut off: |rejected|, by Parseval's equation
///   bound     an upper bound. For orthonormal filters |rejected|: synthesis is an isometry restricted to the
///             volume's box (what was added to the box is cut off; with the symmetric boundary the samples
///             beyond it are). For truncated filters on a period, with B and e their frame_bounds(), d
///             transformed axes and M levels:  B^(dM) |rejected| + E_M |f|,  E_1 = (1+e)^d - 1,  E_m = E_1 +
///             B^(2d) E_(m-1) the relative error of m levels there and back,  |f| <= B^(dM) |c| / (1 - E_M)
///   Coefficients that interpolate: with R the largest response of phi's samples, R^d |rejected|.
///   estimate  the same for truncated filters with the symmetric boundary, whose reflected samples add to |f|
enum class ErrorKind { exact, bound, estimate };
[[nodiscard]] std::string_view name(ErrorKind kind);

struct PredictedError {
  ErrorKind kind = ErrorKind::exact;
  double l2 = 0;  ///< root of the sum of squared differences over the voxels
};
template <class T>
[[nodiscard]] PredictedError predicted_error(const Decomposition<T>& decomposition,
                                             const RejectionReport& report);

}  // namespace vol::wavelet
