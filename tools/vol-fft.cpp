// vol-fft: the centred spectrum of a volume, or the spectra of a shading or transfer-function model.
//   vol-fft head.nrrd -o spectrum.nrrd --pad 2 --compensate es:6
//   vol-fft spectrum.nrrd -o back.nrrd --inverse
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/checked.h"
#include "base/error.h"
#include "cli/naming.h"
#include "cli/run.h"
#include "cli/spectrum_model.h"
#include "cli/volume_input.h"
#include "fourier/canny.h"
#include "io/any_volume.h"
#include "io/spectrum.h"
#include "io/volume.h"

namespace {

using namespace vol;

struct Options {
  cli::VolumeInput input;
  std::filesystem::path output, wisdom;
  double padding = 2;
  std::string compensation = "none", type = "f32", spectrum;
  cli::SpectrumModelOptions model;
  bool inverse = false;
};

void declare(CLI::App& app, Options& o) {
  cli::add_volume_input(app, o.input, "Volume; with --inverse a spectrum (.nrrd); - is standard input");
  app.add_option("-o,--output", o.output, "Spectrum (.nrrd); with --inverse a volume; - is standard output")
      ->required()
      ->group("Files");
  app.add_option(
         "--wisdom", o.wisdom,
         "FFTW's measured plans: read if there, and written; f32 and f64 each need a file of their own; "
         "without it plans are estimated")
      ->group("Files");

  const char* spectrum = "Spectrum";
  app.add_option("--pad", o.padding, "Padded size over size: 1, 1.25, 1.5, 2 or 4")
      ->check(CLI::IsMember({1.0, 1.25, 1.5, 2.0, 4.0}))
      ->capture_default_str()
      ->group(spectrum);
  app.add_option(
         "--compensate", o.compensation,
         "Divide out what this filter of fvr-slice attenuates: " + fourier::filter_names() + ", or none")
      ->capture_default_str()
      ->group(spectrum);
  app.add_option("--type", o.type, "Of the spectrum: f32 or f64")
      ->check(CLI::IsMember({"f32", "f64"}))
      ->capture_default_str()
      ->group(spectrum);
  auto* inverse = app.add_flag("--inverse", o.inverse, "From a spectrum back to its volume")->group(spectrum);
  app.add_option("--spectrum", o.spectrum, "Inverse: name of the spectrum, of several [the first]")
      ->needs(inverse)
      ->group(spectrum);

  cli::add_spectrum_model(app, o.model);
  for (const char* forward :
       {"--pad", "--compensate", "--type", "--shading", "--bezier", "--bands", "--edges"}) {
    inverse->excludes(app.get_option(forward));
  }
}

/// States what will be taken, before it is.
void require_memory(std::int64_t bytes, const char* what, cli::Record& record) {
  record.count("planned_bytes", bytes);
  const std::int64_t limit = io::ReadOptions::physical_memory();
  constexpr std::int64_t kMiB = 1 << 20;
  if (record.verbose()) record.say(std::string(what) + " will take " + std::to_string(bytes / kMiB) + " MiB");
  if (bytes > limit) {
    throw Error(std::string(what) + " would take " + std::to_string(bytes / kMiB) + " MiB, of " +
                std::to_string(limit / kMiB) + " MiB in this machine; use less --pad, or --type f32");
  }
}

template <class T>
fourier::Planning planning(const Options& o) {
  if (o.wisdom.empty()) return fourier::Planning::estimate;
  if (std::filesystem::exists(o.wisdom)) fourier::read_wisdom<T>(o.wisdom);
  return fourier::Planning::measure;
}

template <class T>
void write_wisdom(const std::filesystem::path& path) {
  io::OutputFile out(path);
  out.write(fourier::wisdom<T>());
  out.commit();
}

template <class T>
int forward(const Options& o, cli::Record& record) {
  if (!io::is_standard_stream(o.output) && o.output.extension() != ".nrrd") {
    throw Error(o.output.string() + ": a spectrum goes to a .nrrd file, or to - (standard output)");
  }
  io::require_writable(o.output);
  if (!o.wisdom.empty()) io::require_writable(o.wisdom);
  std::optional<fourier::Filter> filter;
  if (o.compensation != "none") filter.emplace(o.compensation, o.padding);
  const cli::SpectrumModel asked(o.model, record);
  const volume::Volume volume = cli::load(o.input, record);
  fourier::SpectrumInfo info;
  info.geometry = volume.geometry();
  info.padding = o.padding;
  if (filter) info.compensation = filter->name();
  info.attributes = volume.attributes;
  for (int a = 0; a < 3; ++a) info.padded[a] = fourier::padded_size(info.geometry.dims[a], o.padding);
  const std::int64_t voxels = info.geometry.count();
  const std::int64_t bytes = voxels * static_cast<std::int64_t>(volume::size_in_bytes(volume.voxel_type()));
  const std::int64_t spectrum_bytes = checked_product(info.count(), 2 * sizeof(T));
  // Canny's detector is done before there are spectra, and leaves a byte a voxel.
  const std::int64_t transform = checked_product(spectrum_bytes, asked.spectra()) +
                                 (o.model.edges ? voxels : 0) + fourier::transform_scratch_bytes<T>(info);
  const std::int64_t detector = o.model.edges ? checked_product(voxels, fourier::kCannyBytes) : 0;
  require_memory(bytes + std::max(transform, detector), "volume and spectra", record);
  if (filter) {
    const auto c = fourier::compensation(*filter, info.geometry.dims, info.padded);
    record.result("largest_compensation", c.largest);
    constexpr double kTooMuch = 1e3;  // three of float's seven digits
    if (c.largest > kTooMuch) {
      char factor[32];
      std::snprintf(factor, sizeof factor, "%.2g", c.largest);
      record.warn("compensation for " + filter->name() + " multiplies voxels by up to " + factor +
                  ", and all errors of the filter there as well; more --pad cures it");
    }
  }
  const auto model = record.timed("model", [&] { return asked.of(volume, info, record); });
  info.model = model.name;
  info.names = model.spectra;
  const auto plan = planning<T>(o);
  const auto spectrum =
      record.repeated("transform", [&] { return fourier::transform<T>(info, model.sources, plan); });
  if (!o.wisdom.empty()) write_wisdom<T>(o.wisdom);
  record.count("spectra", static_cast<std::int64_t>(info.names.size()));
  record.count("spectrum_bytes", fourier::spectrum_bytes<T>(info));
  record.result("padded", {info.padded[0], info.padded[1], info.padded[2]});
  record.timed("write", [&] { io::write_spectrum(o.output, spectrum, record.provenance()); });
  record.output(o.output);
  return 0;
}

template <class T>
volume::Volume inverse_of(io::SpectrumFile& file, const Options& o, cli::Record& record) {
  const auto& names = file.info().names;
  const auto found = o.spectrum.empty() ? names.begin() : std::find(names.begin(), names.end(), o.spectrum);
  if (found == names.end()) throw Error("--spectrum " + o.spectrum + ": the file has none of that name");
  auto spectrum = record.timed("read", [&] { return file.read_spectrum<T>(); });
  const auto plan = planning<T>(o);
  volume::Volume result;
  result.grid = record.timed("transform", [&] {
    return fourier::inverse(spectrum, static_cast<std::size_t>(found - names.begin()), plan);
  });
  if (!o.wisdom.empty()) write_wisdom<T>(o.wisdom);
  return result;
}

int inverse(io::SpectrumFile& file, const Options& o, cli::Record& record) {
  const fourier::SpectrumInfo& info = file.info();
  const std::int64_t spectra =
      file.is_double()
          ? fourier::spectrum_bytes<double>(info) + fourier::transform_scratch_bytes<double>(info)
          : fourier::spectrum_bytes<float>(info) + fourier::transform_scratch_bytes<float>(info);
  require_memory(spectra + info.geometry.count() * (file.is_double() ? 8 : 4), "spectra and volume", record);
  auto volume = file.is_double() ? inverse_of<double>(file, o, record) : inverse_of<float>(file, o, record);
  volume.attributes = file.info().attributes;
  cli::save(o.output, volume, record);
  return 0;
}

int inverse(const Options& o, cli::Record& record) {
  io::require_volume_output(o.output);
  if (!o.wisdom.empty()) io::require_writable(o.wisdom);
  record.input(o.input.path);
  io::SpectrumFile file(o.input.path);
  return cli::naming(o.input.path, [&] { return inverse(file, o, record); });
}

int work(const Options& o, cli::Record& record) {
  if (o.inverse) return inverse(o, record);
  return o.type == "f64" ? forward<double>(o, record) : forward<float>(o, record);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The centred half spectrum of a volume, for fvr-slice: padded, compensated for the filter it will be\n"
      "resampled with, and for a shading or transfer-function model the spectra that its pictures are sums "
      "of."};
  Options options;
  declare(app, options);
  return cli::run(
      app,
      {.name = "vol-fft",
       .example = "vol-phantom gaussians -o - | vol-fft - -o spectrum.nrrd --pad 2 --compensate es:6",
       .references = "Totsuka & Levoy 1993; Cheng 2007",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
