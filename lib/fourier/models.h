#pragma once
#include <limits>
#include <optional>

#include "fourier/slice.h"
#include "transfer/bezier.h"

namespace vol::fourier {

/// Which spectra a model needs of a volume, and what its picture adds them up with. Pictures are linear in
/// the field, so a shading function that is a sum of (what depends on the place) times (what depends on the
/// view) is one spectrum a term (Levoy 1992; Totsuka & Levoy 1993).
struct Model {
  std::string name = "plain";
  std::vector<std::string> spectra{"f"};
  std::vector<RowSource> sources;
};

/// f itself. The volume must outlive the model's sources, here and below.
[[nodiscard]] Model plain_model(const volume::Volume& volume);
/// f, f Dx, f Dy, f Dz with D = (P - box centre)/half diagonal, in world axes.
[[nodiscard]] Model depth_cue_model(const volume::Volume& volume);
/// f, f Nx, f Ny, f Nz with N = -grad f/|grad f|, 0 where the gradient vanishes; central differences,
/// one-sided at the border, in world axes.
[[nodiscard]] Model directional_model(const volume::Volume& volume);
/// v C(n-1, i) (1 - v)^(n-1-i) v^i for i = 0 .. n-1, v = f scaled from `range` to [0, 1] and clamped.
/// \throws vol::Error unless 1 <= n <= transfer::kMostControlPoints and the range has an extent
[[nodiscard]] Model bezier_model(const volume::Volume& volume, int n, const volume::Range& range);

/// lo <= f < hi; a band whose hi is the volume's largest value holds that too.
struct Band {
  double lo, hi;
};
/// f within each band, else 0; with `edges` one more, from canny_edges().
[[nodiscard]] Model bands_model(const volume::Volume& volume, const std::vector<Band>& bands, bool edges);

/// Weights of the spectra of "depth-cue" for f (strength/2)(1 + V.D), V from the volume toward the viewer.
[[nodiscard]] std::vector<double> depth_cue_weights(const camera::Camera& camera, double strength);
/// Weights of "directional" for f (1 + L.N)/2, L toward the light. \throws vol::Error where `light` has no
/// direction
[[nodiscard]] std::vector<double> directional_weights(const Vec3& light);

}  // namespace vol::fourier
