#include "cli/fvr.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/checked.h"
#include "base/error.h"
#include "base/heap.h"
#include "cli/fvr_words.h"
#include "cli/options.h"
#include "fourier/projection.h"
#include "image/exposure.h"
#include "io/png.h"
#include "io/volume.h"
#include "io/write_image.h"

namespace vol::cli {

namespace {

image::Image image_of(const std::vector<Buffer<float>>& planes, int width, int height) {
  image::Image image(width, height, {"R", "G", "B", "A"});
  for (std::size_t p = 0; p < planes[0].size(); ++p) {
    float* pixel = &image.pixels[4 * p];
    for (std::size_t c = 0; c < 3; ++c) pixel[c] = planes[planes.size() == 3 ? c : 0][p];
    pixel[3] = 1;
    if (!std::isfinite(pixel[0] + pixel[1] + pixel[2]))
      throw Error("a pixel overflows float; scale the volume");
  }
  return image;
}

/// Picture number i of a stack: x right, y down, z the view.
void put_into(volume::Grid<float>& stack, std::size_t i, const std::vector<Buffer<float>>& planes) {
  if (planes.size() != 1)
    throw Error("a stack (.nrrd) holds grey pictures; leave out --band-colours, or write .exr");
  float* to = stack.voxels.data() + i * planes[0].size();
  bool finite = true;
  for (std::size_t p = 0; p < planes[0].size(); ++p) {
    to[p] = planes[0][p];
    finite &= std::isfinite(to[p]);
  }
  if (!finite) throw Error("a pixel overflows float; scale the volume");
}

void write_stack(const FvrOptions& o, volume::Grid<float> stack, Record& record) {
  volume::Volume volume;
  volume.grid = std::move(stack);
  volume.attributes = record.provenance();
  (void)io::write_volume(o.output, volume);
}

struct Job {
  fourier::SliceView view;
  fourier::ChannelWeights weights;
};

std::vector<Job> jobs_of(const FvrOptions& o, const fourier::SpectrumInfo& info,
                         const std::vector<FvrView>& views) {
  const auto size = parse_image_size("--size", o.size);
  const Vec3 centre = info.geometry.centre();
  const double longest = info.geometry.edge_lengths().maxCoeff();
  std::vector<Job> jobs;
  fourier::ChannelWeights curves;  // the same for all views: their file is read once
  for (const auto& v : views) {
    const camera::Camera camera(v.view, centre, longest, size[0], size[1]);
    auto weights = curves.empty() ? fvr_weights(o, info, camera) : curves;
    if (!o.transfer.empty()) curves = weights;
    jobs.push_back({fourier::slice_view(info, camera, size[0], size[1], o.wrap), std::move(weights)});
  }
  return jobs;
}

/// Spectra of files that do not say so are taken at the curves' word.
void warn_of_unknown_range(const FvrOptions& o, const fourier::SpectrumInfo& info, Record& record) {
  if (o.transfer.empty() || info.attributes.contains(kBezierRange)) return;
  record.warn("the spectra do not say over which values their curves are; taken to be those of " +
              o.transfer.string());
}

// The pictures of a run are kept until they are written, so that drawing is timed by itself; of many, in lots
// that stay in the cache.
constexpr std::int64_t kMostInLot = 64, kLotBytes = std::int64_t{4} << 20;

std::int64_t lot_of(std::int64_t views, std::int64_t picture_bytes) {
  return std::min(
      views, std::clamp<std::int64_t>(kLotBytes / std::max<std::int64_t>(picture_bytes, 1), 1, kMostInLot));
}

}  // namespace

void fvr_require_memory(const FvrOptions& o, const fourier::SpectrumInfo& info,
                        const std::vector<FvrView>& views, std::int64_t spectra, std::int64_t real,
                        Record& record) {
  const auto jobs = jobs_of(o, info, views);
  std::int64_t largest = 0, all = 0;  // planes; all are kept while they are small
  std::int64_t scratch = 0;           // of the largest
  for (const Job& job : jobs) {
    const std::int64_t plane = checked_product(
        fourier::SlicePlane<float>::bytes(job.view.width, job.view.height, job.weights.size()),
        real / static_cast<std::int64_t>(sizeof(float)));
    largest = std::max(largest, plane);
    all = std::min(all + plane, fourier::kKeptPlanes);
    scratch =
        std::max(scratch, real == sizeof(double)
                              ? fourier::SlicePlane<double>::scratch_bytes(job.view.width, job.view.height)
                              : fourier::SlicePlane<float>::scratch_bytes(job.view.width, job.view.height));
  }
  const auto views_count = static_cast<std::int64_t>(jobs.size());
  const std::int64_t pixels = jobs.front().view.picture_width * jobs.front().view.picture_height,
                     channels = static_cast<std::int64_t>(jobs.front().weights.size()),
                     lot = lot_of(views_count, 4 * pixels * channels);
  // Drawn in `real`, kept in float; an image of four floats is made of one at a time, or all go into a stack.
  const std::int64_t pictures = checked_product(pixels * channels, lot * 4 + real),
                     written = checked_product(pixels, is_stack(o) ? 4 * views_count : 4 * 4);
  const std::int64_t bytes = spectra + std::max(largest, all) + scratch + pictures + written;
  record.count("planned_bytes", bytes);
  const std::int64_t limit = io::ReadOptions::physical_memory();
  if (bytes > limit) {
    throw Error("spectra, slices and pictures would take " + std::to_string(bytes >> 20) + " MiB, of " +
                std::to_string(limit >> 20) + " MiB in this machine");
  }
}

void fvr_pictures(const FvrOptions& o, const fourier::SpectrumInfo& info, const std::vector<FvrView>& views,
                  const FvrDraw& draw, Record& record) {
  const auto size = parse_image_size("--size", o.size);
  double exposure = given_exposure(o);
  const auto jobs = jobs_of(o, info, views);
  warn_of_unknown_range(o, info, record);
  volume::Grid<float> stack;
  if (is_stack(o)) {
    const double pitch = jobs.front().view.pitch;
    stack.geometry.dims = {size[0], size[1], static_cast<std::int64_t>(views.size())};
    stack.geometry.spacing = Vec3(pitch, pitch, 1);
    stack.voxels.resize(static_cast<std::size_t>(checked_count(stack.geometry.dims)));
    prefer_large_pages(stack.voxels.data(), stack.voxels.size() * sizeof(float));
  }
  std::int64_t frames = 0;
  const auto lot = static_cast<std::size_t>(
      lot_of(static_cast<std::int64_t>(jobs.size()),
             std::int64_t{4} * size[0] * size[1] * static_cast<std::int64_t>(jobs.front().weights.size())));
  std::vector<std::vector<Buffer<float>>> pictures(lot);
  for (std::size_t first = 0; first < jobs.size(); first += lot) {
    const std::size_t last = std::min(jobs.size(), first + lot);
    (void)record.repeated("render", [&] {
      for (std::size_t i = first; i < last; ++i) draw(jobs[i].view, jobs[i].weights, pictures[i - first]);
      return frames += static_cast<std::int64_t>(last - first);
    });
    for (std::size_t i = first; i < last; ++i) {
      if (is_stack(o)) {
        put_into(stack, i, pictures[i - first]);
        continue;
      }
      image::Image image = image_of(pictures[i - first], size[0], size[1]);
      for (const auto& [key, value] : record.provenance()) image.attributes[key] = value;
      image.attributes["precis.view"] = nlohmann::json{views[i].view.azimuth, views[i].view.elevation}.dump();
      if (exposure == 0) exposure = image::exposure_to_white(image);
      record.timed("write", [&] {
        if (is_png(views[i].output, o.format)) {
          io::write_png(views[i].output, image, {.scale = exposure});
        } else {
          io::write_image(views[i].output, image, o.format);
        }
      });
      record.output(views[i].output);
    }
  }
  if (is_stack(o)) {
    record.timed("write", [&] { write_stack(o, std::move(stack), record); });
    record.output(o.output);
  }
  record.count("views", static_cast<std::int64_t>(views.size()));
  record.count("frames", frames);
  if (!is_stack(o) && is_png(views.front().output, o.format)) record.result("exposure", exposure);
}

}  // namespace vol::cli
