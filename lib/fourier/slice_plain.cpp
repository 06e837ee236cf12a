#include <cmath>

#include "base/error.h"
#include "fourier/slice.h"

namespace vol::fourier {

SliceView slice_view(const SpectrumInfo& info, const camera::Camera& camera, int width, int height,
                     bool wrap) {
  if (camera.projection() != camera::Projection::orthographic) {
    throw Error(
        "Fourier volume rendering has orthographic views only; give --width instead of a field of view");
  }
  constexpr double kLargest = 32768;
  const volume::GridGeometry& g = info.geometry;
  const Mat3 steps = g.direction * g.spacing.asDiagonal();  // world steps between samples
  const double pitch = camera.width() / width;
  const Vec3 down = -camera.up();
  const Vec3 to_centre = g.centre() - camera.eye();
  SliceView view;
  view.pitch = pitch;
  view.picture_width = width;
  view.picture_height = height;
  view.centre_x = to_centre.dot(camera.right()) / pitch;
  view.centre_y = to_centre.dot(down) / pitch;
  const Vec3 half_samples(0.5 * static_cast<double>(g.dims[0] - 1), 0.5 * static_cast<double>(g.dims[1] - 1),
                          0.5 * static_cast<double>(g.dims[2] - 1));
  const auto size = [&](const Vec3& axis, double centre, std::int64_t pixels) {
    if (wrap) return pixels;
    // A replica of the volume lies `size` pixels away, and may come up to the picture's outermost pixel.
    const double reach = (steps.transpose() * axis).cwiseAbs().dot(half_samples) / pitch + std::abs(centre);
    const double needed = std::ceil(reach + 0.5 * static_cast<double>(pixels + 1) - 1e-6);
    if (!(needed <= kLargest)) {
      throw Error("the picture shows so small a part of the volume that the slice would take " +
                  std::to_string(needed) + " pixels; make --width larger or --size smaller");
    }
    const auto enough = static_cast<std::int64_t>(needed);
    return enough <= pixels ? pixels : next_fast_size(enough + (enough - pixels) % 2, true);
  };
  view.width = size(camera.right(), view.centre_x, width);
  view.height = size(down, view.centre_y, height);
  const Vec3 m(static_cast<double>(info.padded[0]), static_cast<double>(info.padded[1]),
               static_cast<double>(info.padded[2]));
  view.per_x = m.cwiseProduct(steps.transpose() * camera.right()) / (static_cast<double>(view.width) * pitch);
  view.per_y = m.cwiseProduct(steps.transpose() * down) / (static_cast<double>(view.height) * pitch);
  view.nyquist = 0.5 * m;
  view.scale = std::abs(steps.determinant()) /
               (pitch * pitch * static_cast<double>(view.width) * static_cast<double>(view.height));
  // The farthest point, too.
  if (!(kLargest * (view.per_x.cwiseAbs() + view.per_y.cwiseAbs())).allFinite() || !(view.scale > 0) ||
      !std::isfinite(view.scale) || !std::isfinite(view.centre_x) || !std::isfinite(view.centre_y)) {
    throw Error("the picture's width and the volume's steps are too far apart to be computed with");
  }
  return view;
}

bool SliceView::in_box(const Vec3& g) const {
  return (g.array().abs() <= (1 + kRounding) * nyquist.array()).all();
}

double SliceView::face_share(const Vec3& g, bool unpaired_x, bool unpaired_y) const {
  const auto on_face = [this](double at, int axis) {
    return std::abs(at) >= (1 - kRounding) * nyquist[axis];
  };
  // A line lies in a face if it begins there and does not leave it.
  const auto line_in_face = [&](double half, double across, double half_across, int axis) {
    return on_face(half, axis) && std::abs(across * half_across) <= kRounding * nyquist[axis];
  };
  const double half_w = 0.5 * static_cast<double>(width), half_h = 0.5 * static_cast<double>(height);
  double share = 1;
  for (int a = 0; a < 3; ++a) {
    if (!on_face(g[a], a)) continue;
    if (unpaired_x && line_in_face(half_w * per_x[a], per_y[a], half_h, a)) continue;
    if (unpaired_y && line_in_face(half_h * per_y[a], per_x[a], half_w, a)) continue;
    share *= 0.5;
  }
  return share;
}

template <class T>
void slice_line_plain(const SliceSource<T>& source, const Filter& filter, const ChannelWeights& weights,
                      const SliceLine& line, std::complex<double>* out) {
  const int taps = filter.taps();
  const double half = 0.5 * taps;
  std::vector<double> w[3];
  for (auto& axis : w) axis.resize(static_cast<std::size_t>(taps));
  std::vector<std::complex<double>> value(source.fields());
  for (std::int64_t i = 0; i < line.count; ++i) {
    Vec3 g = line.start + static_cast<double>(i) * line.step;
    const bool mirrored = g.x() < 0;  // F(-g) = conj F(g), and only kx >= 0 is stored
    if (mirrored) g = -g;
    std::int64_t first[3];
    for (int a = 0; a < 3; ++a) {
      first[a] = static_cast<std::int64_t>(std::floor(g[a] - half)) + 1;
      for (int t = 0; t < taps; ++t) w[a][t] = filter.weight(g[a] - static_cast<double>(first[a] + t));
    }
    for (std::size_t f = 0; f < value.size(); ++f) {
      std::complex<double> sum = 0;
      for (int c = 0; c < taps; ++c) {
        for (int b = 0; b < taps; ++b) {
          const T* row = source.at(f, first[0], first[1] + b, first[2] + c);
          std::complex<double> along_x = 0;
          for (int a = 0; a < taps; ++a)
            along_x += w[0][a] * std::complex<double>(row[2 * a], row[2 * a + 1]);
          sum += w[1][b] * w[2][c] * along_x;
        }
      }
      value[f] = mirrored ? std::conj(sum) : sum;
    }
    for (std::size_t channel = 0; channel < weights.size(); ++channel) {
      std::complex<double> sum = 0;
      for (std::size_t f = 0; f < value.size(); ++f) sum += weights[channel][f] * value[f];
      out[static_cast<std::int64_t>(channel) * line.count + i] = sum;
    }
  }
}

template void slice_line_plain(const SliceSource<float>&, const Filter&, const ChannelWeights&,
                               const SliceLine&, std::complex<double>*);
template void slice_line_plain(const SliceSource<double>&, const Filter&, const ChannelWeights&,
                               const SliceLine&, std::complex<double>*);

}  // namespace vol::fourier
