#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "base/parallel.h"
#include "wavelet/filters.h"
#include "wavelet/layout.h"
#include "wavelet/significance.h"

namespace vol::wavelet {
namespace {

/// A run of one subband's coefficients: the unit of work, and of order among equals.
struct Chunk {
  std::size_t band;
  std::int64_t begin, end;
};

/// Whether a coefficient's synthesis support meets the box, by axis.
using Meets = std::array<std::vector<char>, 3>;

template <class T>
Meets region_mask(const Decomposition<T>& d, const FilterBank& bank, const Subband<T>& band,
                  const VoxelBox& box) {
  Meets meets;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t n = d.extended_dims[a];
    for (std::int64_t i = 0; i < band.dims[a]; ++i) {
      bool inside = true;
      if (n > 1) {
        const Support s = synthesis_support(bank, band.level, band.lower[a] + i);
        const std::int64_t length = s.last - s.first + 1;
        if (d.boundary == Boundary::symmetric) {
          inside = s.first < box.upper[a] && s.last >= box.lower[a];
        } else {  // begins in the box, or before it and lasts until it comes round
          const std::int64_t ahead = ((s.first - box.lower[a]) % n + n) % n;
          inside = ahead < box.upper[a] - box.lower[a] || ahead + length > n;
        }
      }
      meets[a].push_back(inside);
    }
  }
  return meets;
}

/// The key by which coefficients are ranked, larger first; orders as an unsigned integer, too.
struct Ranking {
  double weight;
  template <class T>
  [[nodiscard]] std::uint64_t key(T c) const {
    return std::bit_cast<std::uint64_t>(weight * std::abs(static_cast<double>(c)));
  }
};

/// Keep everything above `key`, and the first `ties` of those equal to it.
struct Cut {
  std::uint64_t key = 0;
  std::int64_t ties = std::numeric_limits<std::int64_t>::max();
};

constexpr int kDigit = 16;
struct Bins {
  std::vector<std::int64_t> count;
  std::vector<double> energy;
};

template <class T>
class Rejecter {
 public:
  Rejecter(Decomposition<T>& d, const Rejection& rejection) : d_(d), rejection_(rejection) {
    const Wavelet wavelet = make_wavelet(d.wavelet);
    for (std::size_t b = 0; b < d.subbands.size(); ++b) {
      const auto& band = d.subbands[b];
      const auto n = static_cast<std::int64_t>(band.coefficients.size());
      total_ += n;
      rankings_.push_back(
          {significance_weight(rejection.significance, band.level, band.orientation, d.extended_dims)});
      if (rejection.region) masks_.push_back(region_mask(d, wavelet.bank, band, *rejection.region));
    }
    const std::int64_t grain =
        std::max<std::int64_t>(std::int64_t{1} << 18, total_ / 16);  // a histogram each: keep them few
    for (std::size_t b = 0; b < d.subbands.size(); ++b) {
      const auto n = static_cast<std::int64_t>(d.subbands[b].coefficients.size());
      for (std::int64_t i = 0; i < n; i += grain) chunks_.push_back({b, i, std::min(n, i + grain)});
    }
  }

  RejectionReport run() {
    struct Extent {
      double largest = 0;
      std::int64_t nonzero = 0;
    };
    const Extent extent = over_chunks<Extent>(
        [&](const Chunk& chunk) {
          Extent e;
          for (std::int64_t i = chunk.begin; i < chunk.end; ++i) {
            const double c = std::abs(static_cast<double>(at(chunk, i)));
            e.largest = std::max(e.largest, c);
            e.nonzero += c != 0;
          }
          return e;
        },
        [](Extent& all, const Extent& e) {
          all.largest = std::max(all.largest, e.largest);
          all.nonzero += e.nonzero;
        });
    if (extent.largest > 0) scale_ = std::exp2(std::min(std::ilogb(extent.largest), 1000));
    RejectionReport report = apply(find_cut());
    report.total = total_;
    report.nonzero = extent.nonzero;
    return report;
  }

 private:
  template <class Partial, class Map, class Fold>
  Partial over_chunks(const Map& map, const Fold& fold) {
    return parallel_reduce<Partial>(
        0, static_cast<std::int64_t>(chunks_.size()), 1,
        [&](std::int64_t c, std::int64_t) { return map(chunks_[static_cast<std::size_t>(c)]); }, fold);
  }
  T& at(const Chunk& chunk, std::int64_t i) {
    return d_.subbands[chunk.band].coefficients[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] double scaled_energy(T c) const {
    const double x = static_cast<double>(c) / scale_;
    return x * x;
  }
  /// Kept because of where it is; the criterion has no say.
  [[nodiscard]] bool in_region(const Chunk& chunk, std::int64_t i) const {
    if (!rejection_.region) return false;
    const auto& dims = d_.subbands[chunk.band].dims;
    const auto& meets = masks_[chunk.band];
    return meets[0][static_cast<std::size_t>(i % dims[0])] &&
           meets[1][static_cast<std::size_t>(i / dims[0] % dims[1])] &&
           meets[2][static_cast<std::size_t>(i / dims[0] / dims[1])];
  }

  Cut find_cut() {
    constexpr std::uint64_t all = 0, none = std::numeric_limits<std::uint64_t>::max();
    if (rejection_.threshold) {
      const double t = *rejection_.threshold;
      return {
          std::bit_cast<std::uint64_t>(rejection_.significance == Significance::energy ? std::sqrt(t) : t)};
    }
    if (rejection_.keep)
      return *rejection_.keep == 0 ? Cut{none} : select(false, static_cast<double>(*rejection_.keep));
    if (rejection_.keep_energy && *rejection_.keep_energy < 1) {
      if (*rejection_.keep_energy == 0) return {none};
      const double total = over_chunks<CompensatedSum>(
                               [&](const Chunk& chunk) {
                                 CompensatedSum sum;
                                 for (std::int64_t i = chunk.begin; i < chunk.end; ++i) {
                                   if (!in_region(chunk, i)) sum.add(scaled_energy(at(chunk, i)));
                                 }
                                 return sum;
                               },
                               [](CompensatedSum& a, const CompensatedSum& b) { a.add(b); })
                               .value();
      return select(true, total * *rejection_.keep_energy);
    }
    return {rejection_.region && !rejection_.keep_energy ? none : all};
  }

  /// The cut that keeps as few of the most significant as give `wanted` (a number, or an energy): the digits
  /// of its key are found from the highest on, a histogram each.
  Cut select(bool by_energy, double wanted) {
    std::uint64_t prefix = 0;
    for (int shift = 64 - kDigit; shift >= 0; shift -= kDigit) {
      const Bins bins = histogram(prefix, shift, by_energy);
      std::size_t digit = bins.count.size();
      bool found = false;
      while (!found && digit-- > 0) {
        const double here = by_energy ? bins.energy[digit] : static_cast<double>(bins.count[digit]);
        found = bins.count[digit] > 0 && here >= wanted;
        if (!found) wanted -= here;
      }
      if (!found) return {};  // there are no more than wanted: all are kept
      prefix = prefix << kDigit | digit;
    }
    if (!by_energy) return {prefix, static_cast<std::int64_t>(wanted)};
    std::int64_t ties = 0;  // equal in significance, not in energy
    for (const auto& chunk : chunks_) {
      for (std::int64_t i = chunk.begin; i < chunk.end && wanted > 0; ++i) {
        const T c = at(chunk, i);
        if (rankings_[chunk.band].key(c) != prefix || in_region(chunk, i)) continue;
        wanted -= scaled_energy(c);
        ++ties;
      }
    }
    return {prefix, ties};
  }

  Bins histogram(std::uint64_t prefix, int shift, bool energies) {
    constexpr std::size_t digits = std::size_t{1} << kDigit;
    return over_chunks<Bins>(
        [&](const Chunk& chunk) {
          Bins bins{std::vector<std::int64_t>(digits), std::vector<double>(energies ? digits : 0)};
          for (std::int64_t i = chunk.begin; i < chunk.end; ++i) {
            const T c = at(chunk, i);
            const std::uint64_t key = rankings_[chunk.band].key(c);
            if (c == 0 || (shift + kDigit < 64 && key >> (shift + kDigit) != prefix) || in_region(chunk, i))
              continue;
            const auto digit = static_cast<std::size_t>(key >> shift & (digits - 1));
            ++bins.count[digit];
            if (energies) bins.energy[digit] += scaled_energy(c);
          }
          return bins;
        },
        [](Bins& all, const Bins& bins) {
          all.count.resize(bins.count.size());
          all.energy.resize(bins.energy.size());
          for (std::size_t i = 0; i < bins.count.size(); ++i) all.count[i] += bins.count[i];
          for (std::size_t i = 0; i < bins.energy.size(); ++i) all.energy[i] += bins.energy[i];
        });
  }

  /// Ties before each chunk, for those that keep only some of them.
  std::vector<std::int64_t> ties_before(const Cut& cut) {
    std::vector<std::int64_t> ties(chunks_.size() + 1);
    if (cut.ties == std::numeric_limits<std::int64_t>::max()) return ties;
    parallel_for(0, static_cast<std::int64_t>(chunks_.size()), 1, [&](std::int64_t n, std::int64_t) {
      const auto& chunk = chunks_[static_cast<std::size_t>(n)];
      for (std::int64_t i = chunk.begin; i < chunk.end; ++i) {
        const T c = at(chunk, i);
        ties[static_cast<std::size_t>(n) + 1] +=
            c != 0 && rankings_[chunk.band].key(c) == cut.key && !in_region(chunk, i);
      }
    });
    for (std::size_t n = 1; n < ties.size(); ++n) ties[n] += ties[n - 1];
    return ties;
  }

  RejectionReport apply(const Cut& cut) {
    struct Partial {
      std::int64_t kept = 0;
      CompensatedSum energy, rejected;
    };
    const auto ties = ties_before(cut);
    // Alone, a region keeps the approximation everywhere.
    const bool keep_approximation =
        rejection_.region && !rejection_.keep && !rejection_.keep_energy && !rejection_.threshold;
    const Partial all = over_chunks<Partial>(
        [&](const Chunk& chunk) {
          Partial part;
          std::int64_t tie = ties[static_cast<std::size_t>(&chunk - chunks_.data())];
          const Ranking ranking = rankings_[chunk.band];
          const bool whole_band = keep_approximation && d_.subbands[chunk.band].orientation == 0;
          for (std::int64_t i = chunk.begin; i < chunk.end; ++i) {
            T& c = at(chunk, i);
            if (c == 0) continue;
            const double e = scaled_energy(c);
            part.energy.add(e);
            const std::uint64_t key = ranking.key(c);
            bool keep = whole_band || in_region(chunk, i);
            if (!keep) keep = key == cut.key ? tie++ < cut.ties : key > cut.key;
            if (keep) {
              ++part.kept;
            } else {
              part.rejected.add(e);
              c = 0;
            }
          }
          return part;
        },
        [](Partial& sum, const Partial& part) {
          sum.kept += part.kept;
          sum.energy.add(part.energy);
          sum.rejected.add(part.rejected);
        });
    RejectionReport report;
    report.kept = all.kept;
    report.norm = scale_ * std::sqrt(all.energy.value());
    report.rejected_norm = scale_ * std::sqrt(all.rejected.value());
    return report;
  }

  Decomposition<T>& d_;
  const Rejection& rejection_;
  std::vector<Ranking> rankings_;
  std::vector<Meets> masks_;
  std::vector<Chunk> chunks_;
  std::int64_t total_ = 0;
  double scale_ = 1;  // a power of two near the largest coefficient
};

void require_valid(const Rejection& r, const Dims& dims) {
  const int criteria = (r.keep ? 1 : 0) + (r.keep_energy ? 1 : 0) + (r.threshold ? 1 : 0);
  if (criteria > 1)
    throw Error("give one of a number to keep, a share of energy and a threshold, not several");
  if (r.keep && *r.keep < 0)
    throw Error("number of coefficients to keep is " + std::to_string(*r.keep) + "; expected 0 or more");
  if (r.keep_energy && !(*r.keep_energy >= 0 && *r.keep_energy <= 1)) {
    throw Error("share of energy to keep is " + std::to_string(*r.keep_energy) + "; expected 0 to 1");
  }
  if (r.threshold && !(*r.threshold >= 0)) {
    throw Error("threshold is " + std::to_string(*r.threshold) + "; expected 0 or more");
  }
  if (!r.region) return;
  for (std::size_t a = 0; a < 3; ++a) {
    if (r.region->lower[a] < 0 || r.region->upper[a] > dims[a] || r.region->lower[a] >= r.region->upper[a]) {
      throw Error("region " + std::to_string(r.region->lower[a]) + ":" + std::to_string(r.region->upper[a]) +
                  " on axis " + std::string(1, "xyz"[a]) +
                  " is empty or outside 0:" + std::to_string(dims[a]));
    }
  }
}

}  // namespace

template <class T>
RejectionReport reject(Decomposition<T>& decomposition, const Rejection& rejection) {
  require_valid(rejection, decomposition.geometry.dims);
  return Rejecter<T>(decomposition, rejection).run();
}

template RejectionReport reject(Decomposition<float>&, const Rejection&);
template RejectionReport reject(Decomposition<double>&, const Rejection&);

}  // namespace vol::wavelet
