#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "volume/field_sampler.h"
#include "volume/volume.h"
#include "wavelet/decomposition.h"
#include "wavelet/prototypes.h"

namespace vol::wavelet {

struct SplineBasis;

/// A coefficient at one place: with u[a] = (x[a] + shift[a]) / scale[a] - k[a] in index space it adds
/// c f0(u[0]) f1(u[1]) f2(u[2]), f the band's factors.
struct Term {
  double c = 0;  ///< coefficient times the band's weight
  std::array<std::int32_t, 3> k{0, 0, 0};
};

/// All terms of one level and orientation, in Morton order, and a tree of boxes over them.
struct Band {
  static constexpr std::size_t kFanout = 8;
  struct Node {
    std::array<std::int32_t, 3> lower, upper;  ///< of the terms' k, both inclusive
  };

  int level = 1;
  int orientation = 0;
  double weight = 1;            ///< 2^(-level/2) for every transformed axis
  std::array<int, 3> factor{};  ///< numbers of functions of the expansion
  Vec3 scale = Vec3::Ones();
  Vec3 shift = Vec3::Zero();
  Vec3 lower = Vec3::Zero();  ///< support of a factor in u
  Vec3 upper = Vec3::Ones();
  std::array<std::int64_t, 3> period{};  ///< of k, on a transformed axis; 0 on others
  bool b_splines = false;                ///< of a spline wavelet's band: its factors are B-splines
  std::vector<Term> terms;
  std::vector<std::vector<Node>> nodes;  ///< [0]: one for kFanout terms; the last: one node

  /// Box in index space outside of which a node's terms vanish.
  [[nodiscard]] Box3 box(const Node& node) const;
  [[nodiscard]] Box3 box(const Term& term) const { return box(Node{term.k, term.k}); }

  /// Calls f(term) for each term whose own box passes meets(box), in the terms' order. meets must hold for a
  /// box that contains one for which it holds.
  template <class Meets, class F>
  void visit(const Meets& meets, const F& f) const {
    if (!nodes.empty()) visit(nodes.size() - 1, 0, meets, f);
  }

 private:
  template <class Meets, class F>
  void visit(std::size_t depth, std::size_t node, const Meets& meets, const F& f) const {
    if (!meets(box(nodes[depth][node]))) return;
    const std::size_t begin = node * kFanout;
    const std::size_t count = depth == 0 ? terms.size() : nodes[depth - 1].size();
    for (std::size_t i = begin; i < begin + kFanout && i < count; ++i) {
      if (depth > 0) {
        visit(depth - 1, i, meets, f);
      } else if (meets(box(terms[i]))) {
        f(terms[i]);
      }
    }
  }
};

struct ExpansionOptions {
  int depth = 6;  ///< splines on multiples of 2^-depth; haar and Battle-Lemarie need none
  /// Where a band of Battle-Lemarie has many terms, B-splines in their place (spline_basis.h): the same field
  /// to rounding, of functions that reach over 4 samples instead of the whole axis.
  bool b_splines = true;
  std::int64_t memory_limit = std::numeric_limits<std::int64_t>::max();  ///< of planned_bytes()
};

/// The field that a wavelet transform stands for, without rebuilding its samples (Gross, Lippert, Dreger &
/// Koch 1995, section 4.1):
///   f(x) = sum_j c[j] w_j(x),  w_j a product of phi(2^-m (x + s) - k) or psi(...) times 2^(-m/2) an axis,
/// x in samples: equal to sum_k c0[k] phi(x - k + s), c0 the finest coefficients, up to the deviation of the
/// prototypes. Where c0 are the samples, s is mu, the first moment of phi, so that pictures do not shift, and
/// f does not go through them but for Haar; coefficients of `interpolate` take f through all voxels
/// (initialisation.h). What the transform extended the volume by lies outside the bounds; the
/// transform's period is that of the extended box, and functions that reach over its end come in on the other
/// side. Along an axis of one sample f is constant. A FieldSampler. Only coefficients that are not zero are
/// stored and visited, once for each place where their function meets the box; those of a band turned into
/// B-splines are those of the B-splines.
class Expansion {
 public:
  /// Move the decomposition in where it is not needed any more: each subband's coefficients are freed as soon
  /// as its terms are made. What will be taken is counted beforehand. Throws vol::Error on a decomposition
  /// that validate() refuses, a symmetric boundary (its reflected coefficients beyond the box are not
  /// stored), an axis of 2^30 samples or more, and over options.memory_limit.
  template <class T>
  explicit Expansion(Decomposition<T> decomposition, const ExpansionOptions& options = {});

  /// The same without the bands of levels finer than this, a copy of the others; what it says of coefficients
  /// and planned bytes is still the whole's.
  /// \param memory_limit  of all terms and the copy's; \throws vol::Error over it, before anything is copied
  [[nodiscard]] Expansion from_level(
      int finest, std::int64_t memory_limit = std::numeric_limits<std::int64_t>::max()) const;
  /// Of terms and their trees, from a level on.
  [[nodiscard]] std::int64_t bytes_from(int finest) const;

  [[nodiscard]] double value(const Vec3& p_world) const;
  [[nodiscard]] Vec3 gradient(const Vec3& p_world) const;
  [[nodiscard]] const volume::FieldBounds& bounds() const { return bounds_; }

  [[nodiscard]] double value_index(const Vec3& p_index) const;  ///< not clamped
  [[nodiscard]] Vec3 gradient_index(const Vec3& p_index) const;

  [[nodiscard]] const volume::GridGeometry& geometry() const { return geometry_; }
  [[nodiscard]] const Box3& index_box() const { return box_; }
  [[nodiscard]] const std::vector<Band>& bands() const { return bands_; }  ///< those with terms
  [[nodiscard]] const PiecewiseCubic& function(int number) const {
    return functions_[static_cast<std::size_t>(number)];
  }
  [[nodiscard]] std::int64_t coefficients() const { return coefficients_; }  ///< that are not zero
  /// Taken at most at once while it was made, the decomposition included; without the basis functions.
  [[nodiscard]] std::int64_t planned_bytes() const { return planned_bytes_; }
  /// Largest distance of phi and of psi from the true functions, found at 8 points between knots: a lower
  /// bound.
  [[nodiscard]] double phi_deviation() const { return phi_deviation_; }
  [[nodiscard]] double psi_deviation() const { return psi_deviation_; }

 private:
  Expansion() = default;
  /// Terms of every subband; sets coefficients_ and planned_bytes_. Turns those bands into bands of B-splines
  /// that are better so.
  template <class T>
  std::vector<std::int64_t> count_terms(const Decomposition<T>& decomposition, const SplineBasis* basis,
                                        std::vector<Band>& bands, std::int64_t limit);
  [[nodiscard]] int number_of(const PiecewiseCubic& f);  ///< among functions_, added where it is new

  volume::GridGeometry geometry_;
  volume::FieldBounds bounds_;
  Box3 box_;
  Mat3 world_to_index_;
  std::vector<PiecewiseCubic> functions_;
  std::vector<Band> bands_;
  std::int64_t coefficients_ = 0, planned_bytes_ = 0;
  double phi_deviation_ = 0, psi_deviation_ = 0;
};

/// Integral of c times a band's function along the line origin + t direction, t in [begin, end], in index
/// space (Gross et al., eq. 31-37). Exact but for rounding: between knots each factor is a polynomial in t,
/// written about the middle of the piece so that none of its digits are lost; their product is of degree 9 at
/// most and is integrated in closed form.
/// \param pieces  if given, the number of polynomial pieces is added
[[nodiscard]] double line_integral(const Expansion& expansion, const Band& band, const Term& term,
                                   const Vec3& origin, const Vec3& direction, double begin, double end,
                                   std::int64_t* pieces = nullptr);

/// The same interval by interval: between two knots of the function's factors that the line crosses.
struct LineInterval {
  double to = 0;        ///< where it ends; it begins where the one before does
  double integral = 0;  ///< c (W(to) - W(from)), Gross et al., eq. 37
};
/// In the order of t; none where the line misses the function.
void line_intervals(const Expansion& expansion, const Band& band, const Term& term, const Vec3& origin,
                    const Vec3& direction, double begin, double end, std::vector<LineInterval>& intervals);

}  // namespace vol::wavelet
