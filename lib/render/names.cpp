#include "render/names.h"

#include <span>
#include <string>

#include "base/error.h"

namespace vol::render {
namespace {

constexpr std::string_view kModels[] = {"composite", "xray", "mip"};
constexpr std::string_view kQuadratures[] = {"rectangle", "trapezoid", "preintegrated", "split", "reference"};
constexpr std::string_view kKernels[] = {"nearest", "trilinear", "catmull-rom", "b-spline"};

template <class Enum>
Enum find(std::span<const std::string_view> names, std::string_view wanted, const char* what) {
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == wanted) return static_cast<Enum>(i);
    all += (i > 0 ? ", " : "") + std::string(names[i]);
  }
  throw Error("unknown " + std::string(what) + " '" + std::string(wanted) + "': one of " + all +
              " is expected");
}

}  // namespace

std::string_view name(Model model) {
  return kModels[static_cast<int>(model)];
}
std::string_view name(Quadrature quadrature) {
  return kQuadratures[static_cast<int>(quadrature)];
}
std::string_view name(volume::Reconstruction kernel) {
  return kKernels[static_cast<int>(kernel)];
}
Model model_from_name(std::string_view name) {
  return find<Model>(kModels, name, "model");
}
Quadrature quadrature_from_name(std::string_view name) {
  return find<Quadrature>(kQuadratures, name, "quadrature");
}
volume::Reconstruction reconstruction_from_name(std::string_view name) {
  return find<volume::Reconstruction>(kKernels, name, "reconstruction");
}

}  // namespace vol::render
