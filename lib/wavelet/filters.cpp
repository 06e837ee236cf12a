#include "wavelet/filters.h"

#include <Eigen/Dense>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <complex>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>

#include "base/error.h"
#include "wavelet/filter_design.h"

namespace vol::wavelet {
namespace {

constexpr int kRadius = 160;  // Battle-Lemarie taps looked at; the tail beyond is below 1e-20

/// g[n] = (-1)^n h[L-1-n], L even.
FilterBank from_taps(std::vector<double> h) {
  FilterBank bank{0, std::move(h), {}};
  const auto taps = bank.h.size();
  for (std::size_t n = 0; n < taps; ++n) bank.g.push_back((n % 2 == 0 ? 1 : -1) * bank.h[taps - 1 - n]);
  return bank;
}

/// h[-radius..radius] and g[n] = (-1)^(n-1) h[1-n] on the window -radius .. radius+1, radius made even.
FilterBank from_centred(const std::vector<double>& h) {
  const auto radius = static_cast<std::int64_t>(h.size() / 2);
  const auto at = [&](std::int64_t n) {
    return std::abs(n) <= radius ? h[static_cast<std::size_t>(n + radius)] : 0.0;
  };
  FilterBank bank;
  bank.first = -(radius + radius % 2);
  for (std::int64_t n = bank.first; n <= 1 - bank.first; ++n) {
    bank.h.push_back(at(n));
    bank.g.push_back((n % 2 == 0 ? -1 : 1) * at(1 - n));
  }
  return bank;
}

/// The shortest centred list whose left-out taps sum to less than `tail` in magnitude.
FilterBank battle_lemarie_bank(int degree, double tail) {
  const auto all = battle_lemarie_taps(degree, kRadius);
  int radius = kRadius;
  for (double left_out = 0; radius > 1; --radius) {
    left_out += 2 * std::abs(all[static_cast<std::size_t>(kRadius + radius)]);
    if (left_out >= tail) break;
  }
  return from_centred({all.begin() + kRadius - radius, all.begin() + kRadius + radius + 1});
}

std::optional<int> number_after(std::string_view text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return std::nullopt;
  text.remove_prefix(prefix.size());
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || (text.size() > 1 && text[0] == '0'))
    return std::nullopt;
  return value;
}

double first_moment(const FilterBank& bank) {
  double sum = 0;
  for (std::int64_t i = 0; i < bank.taps(); ++i) {
    sum += static_cast<double>(bank.first + i) * bank.h[static_cast<std::size_t>(i)];
  }
  return sum / std::numbers::sqrt2;
}

FilterBank folded(const FilterBank& bank, std::int64_t period) {
  const auto n = static_cast<std::size_t>(period);
  FilterBank result{0, std::vector<double>(n), std::vector<double>(n)};
  for (std::int64_t i = 0; i < bank.taps(); ++i) {
    const auto to = static_cast<std::size_t>(((bank.first + i) % period + period) % period);
    result.h[to] += bank.h[static_cast<std::size_t>(i)];
    result.g[to] += bank.g[static_cast<std::size_t>(i)];
  }
  return result;
}

Wavelet design(const std::string& canonical) {
  Wavelet w;
  w.name = canonical;
  if (const auto taps = number_after(canonical, "daubechies-")) {
    w.family = Family::daubechies;
    w.vanishing_moments = *taps / 2;
    w.bank = from_taps(daubechies_taps(*taps));
  } else if (const auto coiflet = number_after(canonical, "coiflet-")) {
    w.family = Family::coiflet;
    w.vanishing_moments = *coiflet / 3;
    w.bank = from_taps(coiflet_taps(*coiflet));
  } else if (canonical == "haar") {
    w.bank = from_taps({1 / std::numbers::sqrt2, 1 / std::numbers::sqrt2});
  } else {
    w.family = Family::battle_lemarie;
    w.degree = canonical.starts_with("battle-lemarie-1") ? 1 : 3;
    w.vanishing_moments = w.degree + 1;
    const auto cut = number_after(canonical, "battle-lemarie-3:");
    w.compact = w.orthonormal = false;
    if (cut) {
      w.compact = true;
      w.bank = from_centred(battle_lemarie_taps(w.degree, *cut / 2));
    } else {
      w.orthonormal = true;
      w.bank = battle_lemarie_bank(w.degree, 1e-16);
    }
  }
  w.mean = w.family == Family::battle_lemarie ? 0 : first_moment(w.bank);
  return w;
}

}  // namespace

std::vector<std::string> wavelet_names() {
  std::vector<std::string> names{"haar"};
  for (int n = 4; n <= 20; n += 2) names.push_back("daubechies-" + std::to_string(n));
  for (int n = 6; n <= 30; n += 6) names.push_back("coiflet-" + std::to_string(n));
  for (const char* n : {"1", "3", "3:29", "3:33"}) names.push_back(std::string("battle-lemarie-") + n);
  return names;
}

Wavelet make_wavelet(std::string_view name) {
  std::string canonical(name);
  if (name == "battle-lemarie" || name.starts_with("battle-lemarie:")) canonical.insert(14, "-3");
  const auto names = wavelet_names();
  if (std::find(names.begin(), names.end(), canonical) == names.end()) {
    std::string list;
    for (const auto& n : names) list += (list.empty() ? "" : " ") + n;
    throw Error("wavelet '" + std::string(name) + "' is not one of " + list);
  }
  static std::mutex mutex;
  static std::map<std::string, Wavelet> designed;
  const std::lock_guard lock(mutex);
  auto found = designed.find(canonical);
  if (found == designed.end()) found = designed.emplace(canonical, design(canonical)).first;
  return found->second;
}

FilterBank periodised(const Wavelet& wavelet, std::int64_t period, double tail) {
  if (wavelet.compact) return wavelet.bank.taps() <= period ? wavelet.bank : folded(wavelet.bank, period);
  FilterBank bank = tail > 1e-16 ? battle_lemarie_bank(wavelet.degree, tail) : wavelet.bank;
  if (bank.taps() <= period) return bank;
  const auto h = battle_lemarie_periodised(wavelet.degree, static_cast<int>(period));
  bank = {0, h, {}};
  for (std::int64_t n = 0; n < period; ++n) {
    bank.g.push_back((n % 2 == 0 ? -1 : 1) * h[static_cast<std::size_t>((1 - n + period) % period)]);
  }
  return bank;
}

Support synthesis_support(const FilterBank& bank, int level, std::int64_t k) {
  const std::int64_t scale = std::int64_t{1} << level;
  return {scale * k + (scale - 1) * bank.first, scale * k + (scale - 1) * bank.last()};
}

FrameBounds frame_bounds(const Wavelet& wavelet) {
  if (wavelet.orthonormal) return {};
  constexpr int kFrequencies = 4096;
  const auto& bank = wavelet.bank;
  double norm = 0, error = 0;
  for (int k = 0; k < kFrequencies; ++k) {
    // Rows: the two aliases w and w + pi; columns: low and high. Synthesis is M, there and back M M*.
    Eigen::Matrix2cd m = Eigen::Matrix2cd::Zero();
    for (std::int64_t i = 0; i < bank.taps(); ++i) {
      for (int alias = 0; alias < 2; ++alias) {
        const double w = std::numbers::pi * (2.0 * k / kFrequencies + alias);
        const auto phase = std::polar(1 / std::numbers::sqrt2, -w * static_cast<double>(bank.first + i));
        m(alias, 0) += bank.h[static_cast<std::size_t>(i)] * phase;
        m(alias, 1) += bank.g[static_cast<std::size_t>(i)] * phase;
      }
    }
    norm = std::max(norm, m.jacobiSvd().singularValues()(0));
    error = std::max(error, (m * m.adjoint() - Eigen::Matrix2cd::Identity()).jacobiSvd().singularValues()(0));
  }
  return {norm * 1.0001, error * 1.0001};
}

}  // namespace vol::wavelet
