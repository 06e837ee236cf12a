#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "wavelet/expansion.h"
#include "wavelet/factor_bounds.h"

namespace vol::wavelet {

/// The terms of an expansion, ready for lines: bounds of its basis functions; where the functions of an axis
/// were folded to the transform's period, every coefficient once, with a factor that is periodic, in place of
/// its images, whose jumps at the period's ends would not be seen to cancel. Refers to the expansion, which
/// must live longer.
class LineTerms {
 public:
  explicit LineTerms(const Expansion& expansion);
  LineTerms(const LineTerms&) = delete;  // its bands refer to its bounds
  LineTerms& operator=(const LineTerms&) = delete;

  struct Axis {
    const FactorBounds* factor = nullptr;
    double per_index = 1;  ///< knots an index step
    double knots = 1;      ///< knots a step of k
    double first = 0;      ///< q at index 0 for k = 0, q counted in knots from the function's first
  };
  struct BandTerms {
    const Band* band = nullptr;
    std::array<Axis, 3> axes;
    std::vector<Term> terms;  ///< where an axis is periodic; else the band's own
    [[nodiscard]] bool periodic() const {
      return axes[0].factor->periodic() || axes[1].factor->periodic() || axes[2].factor->periodic();
    }
  };
  [[nodiscard]] const Expansion& expansion() const { return *expansion_; }
  [[nodiscard]] const std::vector<BandTerms>& bands() const { return bands_; }

  /// The Lipschitz bound of Gross et al. (45) over the whole box, in value per index step, and what goes with
  /// it for the derivative along a line of one index step a unit: the paper's, for comparison.
  struct Global {
    double slope = 0;  ///< sum_j |c_j| (max|b1'| max|b2| max|b3| + ...) >= |grad f|
    double bend = 0;   ///< the same with second derivatives >= |f''| along any line
    double jump = 0;   ///< of all jumps of f that a line can meet
    double kink = 0;   ///< of all jumps of its derivative
    double size = 0;   ///< of |f|
  };
  [[nodiscard]] Global global() const;

 private:
  const Expansion* expansion_;
  std::vector<FactorBounds> factors_;
  std::vector<BandTerms> bands_;
};

/// An expansion along a line origin + t direction, t in [begin, end], in index space: of the terms that the
/// line meets, on any part of it only those that meet that part. Keeps its memory from line to line; not for
/// two threads at a time.
class LineField {
 public:
  explicit LineField(const LineTerms& terms);

  /// Numbers of terms, a stack: of a part first, of a part of it behind.
  using List = std::vector<std::uint32_t>;

  /// Gathers the terms that the line meets.
  void set(const Vec3& origin, const Vec3& direction, double begin, double end);
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(active_.size()); }

  /// Puts on top of the list those of its entries from `from` to `to` that meet [a, b].
  void narrow(List& list, std::size_t from, std::size_t to, double a, double b) const;

  struct Sample {
    double f = 0;      ///< value
    double slope = 0;  ///< df/dt, Gross et al. (46)
  };
  [[nodiscard]] Sample at(double t, const List& list, std::size_t from, std::size_t to);
  /// Index space gradient, Gross et al. (43).
  /// \param size  if given, the sum of the terms' magnitudes, of which rounding is a part in 1e16
  [[nodiscard]] Vec3 gradient(double t, const List& list, std::size_t from, std::size_t to,
                              Vec3* size = nullptr);

  /// On [a, b]: (45) computed from the terms at hand, along the line.
  struct Bound {
    double slope = 0;  ///< of |df/dt|
    double bend = 0;   ///< of |d2f/dt2|
    double jump = 0;   ///< sum of |jumps of f|; only haar's functions jump
    double kink = 0;   ///< sum of |jumps of df/dt|, where f itself does not jump
    double size = 0;   ///< sum of |terms|
  };
  [[nodiscard]] Bound bound(double a, double b, const List& list, std::size_t from, std::size_t to);

  /// The knot nearest to the middle of [a, b], none where all the terms are polynomials between a and b.
  [[nodiscard]] std::optional<double> middle_knot(double a, double b, const List& list, std::size_t from,
                                                  std::size_t to) const;
  /// f on [a, b], which holds no knots: coefficients of s^0 .. s^9, t = (a + b)/2 + s (b - a), |s| <= 1/2.
  [[nodiscard]] std::array<double, 10> polynomial(double a, double b, const List& list, std::size_t from,
                                                  std::size_t to);

  [[nodiscard]] std::int64_t terms_visited() const { return visited_; }  ///< by all of the above, so far

 private:
  struct Active {
    double c;
    std::uint32_t band;
    std::array<std::uint32_t, 3> factor;  ///< where in slots_
    double in, out;
  };
  /// One factor of one axis: many terms share it. What was worked out last, and when.
  struct Slot {
    double q0 = 0;  ///< q at t = 0
    std::uint32_t band_axis = 0;
    std::uint64_t sampled = 0, bounded = 0, expanded = 0;
    double value = 0, slope = 0;  ///< df/dt
    FactorBound bound;            ///< in t
    std::array<double, 4> cubic{};
  };
  struct Track {
    const FactorBounds* factor = nullptr;
    double q0 = 0, dq = 0;  ///< of k = 0; knots a unit of t
  };

  void gather(std::uint32_t band, const Vec3& origin, const Vec3& direction, double begin, double end);
  const Slot& sampled(std::uint32_t slot, double t);
  const Slot& bounded(std::uint32_t slot, double a, double b);
  const Slot& expanded(std::uint32_t slot, double a, double b);

  const LineTerms& terms_;
  std::vector<Active> active_;
  std::vector<Slot> slots_;
  std::vector<Track> tracks_;  // three a band
  std::uint64_t now_ = 0;
  std::int64_t visited_ = 0;
};

}  // namespace vol::wavelet
