#include "curvilinear/flow.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.h"

namespace vol::curvilinear {
namespace {

constexpr double kGamma = 1.4;  // of air, PLOT3D's own default

/// The conserved quantities at a point.
struct State {
  double density;
  Vec3 momentum;
  double energy;

  [[nodiscard]] Vec3 velocity() const { return momentum / density; }
  [[nodiscard]] double pressure() const {
    return (kGamma - 1) * (energy - 0.5 * momentum.squaredNorm() / density);
  }
  [[nodiscard]] double sound_squared() const { return kGamma * pressure() / density; }
};

struct Formula {
  VariableName name;
  bool needs_energy, divides;
  double (*value)(const State&);
};

const std::vector<Formula>& formulas() {
  static const std::vector<Formula> kFormulas = {
      {{"momentum-magnitude", "|m|"}, false, false, [](const State& s) { return s.momentum.norm(); }},
      {{"velocity.x", "m.x / density"}, false, true, [](const State& s) { return s.velocity().x(); }},
      {{"velocity.y", "m.y / density"}, false, true, [](const State& s) { return s.velocity().y(); }},
      {{"velocity.z", "m.z / density"}, false, true, [](const State& s) { return s.velocity().z(); }},
      {{"velocity-magnitude", "|m| / density"},
       false,
       true,
       [](const State& s) { return s.velocity().norm(); }},
      {{"pressure", "p = 0.4 (energy - |m|^2 / (2 density))"},
       true,
       true,
       [](const State& s) { return s.pressure(); }},
      {{"temperature", "1.4 p / density"}, true, true, [](const State& s) { return s.sound_squared(); }},
      {{"mach", "velocity magnitude / sqrt(1.4 p / density)"},
       true,
       true,
       [](const State& s) { return s.velocity().norm() / std::sqrt(s.sound_squared()); }},
      {{"entropy", "log(1.4 p / density^1.4)"},
       true,
       true,
       [](const State& s) { return std::log(kGamma * s.pressure()) - kGamma * std::log(s.density); }},
  };
  return kFormulas;
}
constexpr VariableName kVorticity = {"vorticity-magnitude", "|curl velocity|, by differences in the grid"};

/// The arrays a state is made of; those of a block that lacks one are null.
struct Conserved {
  const PointArray* array[5];

  Conserved(const Block& block, std::string_view wanted, bool needs_energy) {
    for (int n = 0; n < 5; ++n) {
      array[n] = block.find(kConserved[n]);
      if (array[n] == nullptr && (n < 4 || needs_energy)) {
        throw Error("variable '" + std::string(wanted) + "' needs the array '" + std::string(kConserved[n]) +
                    "', which the grid does not have");
      }
    }
    if (needs_energy &&
        std::all_of(array[4]->values.begin(), array[4]->values.end(), [](double e) { return e == 0; })) {
      throw Error("variable '" + std::string(wanted) +
                  "' needs the energy, which is 0 at every point of this file");
    }
  }
  [[nodiscard]] State at(std::size_t n) const {
    return {array[0]->values[n], Vec3(array[1]->values[n], array[2]->values[n], array[3]->values[n]),
            array[4] == nullptr ? 0 : array[4]->values[n]};
  }
};

void require_positive(std::string_view wanted, const Block& block, const Conserved& from, bool pressure) {
  std::int64_t bad = 0;
  for (std::size_t n = 0; n < block.points.size(); ++n) {
    const State s = from.at(n);
    bad += !(s.density > 0) || (pressure && !(s.pressure() > 0));
  }
  if (bad > 0) {
    throw Error("variable '" + std::string(wanted) + "': density or pressure is not positive at " +
                std::to_string(bad) + " of " + std::to_string(block.points.size()) + " points");
  }
}

/// Derivative along an axis of a quantity of the points, per point: central, and of order 2 at the border.
template <class T, class F>
T difference(const Block& block, const Dims& at, int axis, const F& f) {
  const auto value = [&](std::int64_t n) -> T {
    Dims p = at;
    p[static_cast<std::size_t>(axis)] = n;
    return f(block.offset(p[0], p[1], p[2]));
  };
  const std::int64_t n = block.dims[static_cast<std::size_t>(axis)], i = at[static_cast<std::size_t>(axis)];
  if (n == 2) return value(1) - value(0);
  if (i == 0) return -1.5 * value(0) + 2.0 * value(1) - 0.5 * value(2);
  if (i == n - 1) return 1.5 * value(n - 1) - 2.0 * value(n - 2) + 0.5 * value(n - 3);
  return 0.5 * (value(i + 1) - value(i - 1));
}

std::vector<double> vorticity_magnitude(const Block& block) {
  const Conserved from(block, kVorticity.name, false);
  require_positive(kVorticity.name, block, from, false);
  std::vector<double> result(block.points.size());
  for (std::int64_t k = 0; k < block.dims[2]; ++k) {
    for (std::int64_t j = 0; j < block.dims[1]; ++j) {
      for (std::int64_t i = 0; i < block.dims[0]; ++i) {
        Mat3 position, velocity;  // column a: derivative along the grid's axis a
        for (int a = 0; a < 3; ++a) {
          position.col(a) =
              difference<Vec3>(block, {i, j, k}, a, [&](std::size_t n) { return block.points[n]; });
          velocity.col(a) =
              difference<Vec3>(block, {i, j, k}, a, [&](std::size_t n) { return from.at(n).velocity(); });
        }
        if (position.determinant() == 0) continue;
        const Mat3 g = velocity * position.inverse();  // g(r, c) = d velocity_r / d world_c
        const double w = Vec3(g(2, 1) - g(1, 2), g(0, 2) - g(2, 0), g(1, 0) - g(0, 1)).norm();
        result[block.offset(i, j, k)] = std::isfinite(w) ? w : 0;
      }
    }
  }
  return result;
}

[[noreturn]] void refuse_name(const Grid& grid, std::string_view name) {
  std::string names;
  for (const auto& array : grid.blocks.at(0).arrays) names += (names.empty() ? "" : ", ") + array.name;
  for (const auto& variable : derived_variables()) names += ", " + std::string(variable.name);
  throw Error("has no variable '" + std::string(name) + "'; there are " + names);
}

}  // namespace

const std::vector<VariableName>& derived_variables() {
  static const std::vector<VariableName> kNames = [] {
    std::vector<VariableName> names;
    for (const auto& formula : formulas()) names.push_back(formula.name);
    names.push_back(kVorticity);
    return names;
  }();
  return kNames;
}

std::vector<std::vector<double>> make_variable(const Grid& grid, std::string_view name) {
  std::vector<std::vector<double>> result;
  const auto& all = formulas();
  const auto formula =
      std::find_if(all.begin(), all.end(), [&](const Formula& f) { return f.name.name == name; });
  for (const Block& block : grid.blocks) {
    if (const PointArray* array = block.find(name)) {
      result.push_back(array->values);
    } else if (name == kVorticity.name) {
      result.push_back(vorticity_magnitude(block));
    } else if (formula == all.end()) {
      refuse_name(grid, name);
    } else {
      const Conserved from(block, name, formula->needs_energy);
      if (formula->divides) require_positive(name, block, from, name == "mach" || name == "entropy");
      std::vector<double>& values = result.emplace_back(block.points.size());
      for (std::size_t n = 0; n < values.size(); ++n) values[n] = formula->value(from.at(n));
    }
  }
  return result;
}

std::string_view default_variable(const Grid& grid) {
  if (grid.blocks.at(0).arrays.empty()) throw Error("grid holds no values, only positions");
  return grid.blocks[0].arrays[0].name;
}

}  // namespace vol::curvilinear
