#pragma once
#include "render/expansion_line.h"
#include "render/picture.h"
#include "render/raycast.h"
#include "render/shading.h"
#include "wavelet/line_field.h"

namespace vol::render {

/// exp(-sum_j c_j dW_j) as the product of (1 - c_j dW_j), Gross, Lippert, Dreger & Koch 1995: `interval` with
/// the parts dW_j between two knots of basis function j (40), of first order in the knots' distance; `basis`
/// with the whole of each function that the ray has left behind (41), which does not converge. Misprints: the
/// c_j stand in front of the product there. Basis functions are those of the expansion's bands, which may be
/// B-splines in place of Battle-Lemarie's. Opposite to `none`, the integral itself.
enum class Linearised { none, interval, basis };

struct CompositeOptions {
  bool transfer = false;       ///< colour and extinction by the scene's transfer function; else f itself
  double extinction = 1;       ///< without: extinction is so many times f, per world length
  bool keep_negative = false;  ///< without: f < 0 is not taken for 0
  Linearised linearised = Linearised::none;  ///< without: takes f < 0 as it is, and no light
};

/// What a picture costs and leaves out, beyond RenderCounts, whose samples are the terms that rays met.
struct CompositeCounts {
  std::int64_t pieces = 0;          ///< polynomial pieces of f, or intervals of basis functions
  std::int64_t evaluations = 0;     ///< with a transfer function: of the pieces' polynomials
  std::int64_t clamped_pieces = 0;  ///< where f < 0 was taken for 0, as far as rays were followed
  double clamped_depth = 0;         ///< largest integral of extinction so left out, of a ray
};

/// Pictures of a wavelet expansion with self-occlusion, never rebuilding its volume:
///   I = integral of c sigma T dt,  T = exp(-integral of sigma).
/// Along a ray f is one polynomial between any two knots (ExpansionLine). Where extinction is f itself, the
/// medium is white and T exact (ExtinctionIntegral); through a transfer function the pieces are those of the
/// reference integral (ReferenceIntegral), to options.tolerance. Shading by the analytic gradient, as
/// BlinnPhong has it. Linearised, I is the sum over f's pieces of their integral times the linearised T in
/// front of them (42). R = G = B = I without a transfer function, A = 1 - T, samples the terms met, depth
/// where T falls to 1/2.
///
/// Refers to the expansion, which must live longer.
class WaveletComposite {
 public:
  /// \throws vol::Error on extinction below 0 or not finite, linearised with a transfer function or shading,
  ///         and what require_valid() and the scene's optics throw
  WaveletComposite(const wavelet::Expansion& expansion, const Scene& scene, const RenderOptions& options,
                   const CompositeOptions& composite);
  WaveletComposite(const WaveletComposite&) = delete;
  WaveletComposite& operator=(const WaveletComposite&) = delete;

  /// \throws vol::Error on a pixel that float cannot hold
  [[nodiscard]] RenderResult draw(CompositeCounts* counts = nullptr) const;

  /// One ray, in double; adds what it took.
  [[nodiscard]] Pixel cast(const camera::Ray& ray, const Chord& chord, RenderCounts& spent,
                           CompositeCounts& counts) const;

 private:
  [[nodiscard]] Pixel through_transfer(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                       RenderCounts& spent, CompositeCounts& counts) const;
  [[nodiscard]] Pixel by_extinction(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                    RenderCounts& spent, CompositeCounts& counts) const;
  [[nodiscard]] Pixel linearised(ExpansionLine& line, const camera::Ray& ray, const Chord& chord,
                                 CompositeCounts& counts) const;

  const wavelet::Expansion& expansion_;
  Scene scene_;
  RenderOptions options_;
  CompositeOptions composite_;
  wavelet::LineTerms terms_;
  std::optional<Optics> optics_;
  std::optional<BlinnPhong> shading_;
};

}  // namespace vol::render
