#pragma once
#include <string_view>
#include <vector>

#include "curvilinear/grid.h"

namespace vol::curvilinear {

/// The five conserved quantities of a PLOT3D solution, by these names: density rho, momentum.x .. z = rho u,
/// rho v, rho w, and energy e, the total energy per volume; lengths, speeds (of sound) and density by their
/// free-stream values.
inline constexpr std::string_view kConserved[5] = {"density", "momentum.x", "momentum.y", "momentum.z",
                                                   "energy"};

struct VariableName {
  std::string_view name;
  std::string_view description;  ///< one line with the formula
};
/// What make_variable() derives besides the arrays of the grid, in the order of the help.
[[nodiscard]] const std::vector<VariableName>& derived_variables();

/// A scalar of every point of every block, in the blocks' order: an array of that name, or derived from the
/// conserved quantities, gamma = 1.4:
///   momentum-magnitude |m|;  velocity.x .. z and velocity-magnitude = m / rho;
///   pressure p = (gamma - 1)(e - |m|^2 / (2 rho));  temperature = gamma p / rho, which is 1 where the speed
///   of sound is that of the free stream;  mach = |m| / rho / sqrt(gamma p / rho); entropy = log(gamma p /
///   rho^gamma), 0 in the free stream, in units of the specific heat at constant volume;  vorticity-magnitude
///   = |curl (m / rho)|, by central differences in the grid's own coordinates, of second order at the border,
///   turned to the world by the grid's Jacobian; 0 where that vanishes.
///
/// \throws vol::Error on a name that is none, listing what there is; where a quantity it needs is missing or
/// its energy is 0 throughout; and where density or pressure is not positive, with a count
[[nodiscard]] std::vector<std::vector<double>> make_variable(const Grid& grid, std::string_view name);

/// Name of the variable that is drawn unless one is named: the first array.
[[nodiscard]] std::string_view default_variable(const Grid& grid);

}  // namespace vol::curvilinear
