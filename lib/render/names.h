#pragma once
#include <string_view>

#include "render/options.h"

// The words that scenes and command lines use. from_name throws vol::Error that lists them.
namespace vol::render {

[[nodiscard]] std::string_view name(Model model);            ///< composite xray mip
[[nodiscard]] std::string_view name(Quadrature quadrature);  ///< rectangle trapezoid ...
[[nodiscard]] std::string_view name(
    volume::Reconstruction kernel);  ///< nearest trilinear catmull-rom b-spline
[[nodiscard]] Model model_from_name(std::string_view name);
[[nodiscard]] Quadrature quadrature_from_name(std::string_view name);
[[nodiscard]] volume::Reconstruction reconstruction_from_name(std::string_view name);

}  // namespace vol::render
