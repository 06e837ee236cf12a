// vol-info: what a file holds: format, size, type, geometry, range, mean, histogram, content hash,
// provenance.
//   vol-info head.nrrd
//   vol-info head.nrrd --histogram 16 --json
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/grid_input.h"
#include "cli/run.h"
#include "cli/sha256.h"
#include "cli/volume_input.h"
#include "io/index.h"
#include "io/spectrum.h"
#include "io/vdb.h"
#include "io/volume.h"
#include "volume/statistics.h"

namespace {

using namespace vol;
using nlohmann::ordered_json;

struct Options {
  std::vector<std::string> files;
  cli::VolumeInput input;
  int bins = 0;
  bool json = false, checksum = false;
  cli::GridInput grid;
};

std::vector<double> list(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

void add_geometry(ordered_json& info, const volume::GridGeometry& g) {
  info["dims"] = g.dims;
  info["spacing"] = list(g.spacing);
  info["origin"] = list(g.origin);
  info["direction"] = {list(g.direction.col(0)), list(g.direction.col(1)), list(g.direction.col(2))};
  info["space"] = std::string(volume::name(g.space));
}

/// SHA-256 of what the volume is: dims, type, geometry, then its voxels, little-endian. Independent of file
/// format and attributes.
std::string content_hash(const volume::Volume& v) {
  const auto& g = v.geometry();
  cli::Sha256 hash;
  hash.update(g.dims.data(), sizeof g.dims);
  const auto add_text = [&](std::string_view text) { hash.update(text.data(), text.size()); };
  add_text(volume::name(v.voxel_type()));
  add_text(volume::name(g.space));
  hash.update(g.spacing.data(), 3 * sizeof(double));
  hash.update(g.origin.data(), 3 * sizeof(double));
  hash.update(g.direction.data(), 9 * sizeof(double));
  volume::visit(v, [&](const auto& grid) {
    hash.update(grid.voxels.data(), grid.voxels.size() * sizeof(grid.voxels[0]));
  });
  return hash.hex();
}

void add_histogram(ordered_json& info, const volume::Volume& v, const volume::Range& range, int bins) {
  info["histogram"] = {{"min", range.min}, {"max", range.max}, {"counts", volume::histogram(v, range, bins)}};
}

/// An index volume is described by its entries; the bytes that pack them say nothing to a reader.
ordered_json describe(const volume::Volume& file, const Options& o) {
  const bool is_index = io::is_index(file);
  const volume::Volume entries = is_index ? io::unpack_index(file) : volume::Volume{};
  const volume::Volume& v = is_index ? entries : file;
  ordered_json info;
  add_geometry(info, v.geometry());
  info["type"] = is_index ? "4 bits" : std::string(volume::name(v.voxel_type()));
  info["voxel_bytes"] =
      file.geometry().count() * static_cast<std::int64_t>(volume::size_in_bytes(file.voxel_type()));
  const auto figures = volume::statistics(v);
  info["min"] = figures.range.min;
  info["max"] = figures.range.max;
  info["mean"] = figures.mean;
  info["standard_deviation"] = figures.standard_deviation;
  info["zeros"] = figures.zeros;
  if (is_index) {
    add_histogram(info, v, {0, 16}, 16);  // a bin an entry's value
  } else if (o.bins > 0) {
    add_histogram(info, v, figures.range, o.bins);
  }
  if (o.checksum) info["content_sha256"] = content_hash(file);
  info["attributes"] = file.attributes;
  return info;
}

template <class T>
ordered_json describe(const wavelet::Decomposition<T>& d) {
  ordered_json info;
  info["wavelet"] = d.wavelet;
  info["levels"] = d.levels;
  info["boundary"] = d.boundary == wavelet::Boundary::periodic ? "periodic" : "symmetric";
  info["initialisation"] = d.initialisation == wavelet::Initialisation::samples ? "samples" : "interpolate";
  add_geometry(info, d.geometry);
  info["extended_dims"] = d.extended_dims;
  info["type"] = std::string(volume::name(d.voxel_type));
  info["min"] = d.range.min;
  info["max"] = d.range.max;
  std::int64_t kept = 0, total = 0;
  for (const auto& band : d.subbands) {
    std::int64_t nonzero = 0;
    for (const T c : band.coefficients) nonzero += c != T{0};
    const auto count = static_cast<std::int64_t>(band.coefficients.size());
    info["subbands"].push_back(
        {{"name", "level" + std::to_string(band.level) + "." + wavelet::orientation_name(band.orientation)},
         {"dims", band.dims},
         {"kept", nonzero},
         {"total", count}});
    kept += nonzero;
    total += count;
  }
  info["kept"] = kept;
  info["total"] = total;
  return info;
}

ordered_json describe(const io::SpectrumHeader& header) {
  const fourier::SpectrumInfo& s = header.info;
  ordered_json info;
  add_geometry(info, s.geometry);
  info["padding"] = s.padding;
  info["padded"] = s.padded;
  info["frequencies"] = {s.row_length(), s.padded[1], s.padded[2]};
  info["compensation"] = s.compensation;
  info["model"] = s.model;
  info["spectra"] = s.names;
  info["type"] = header.is_double ? "complex f64" : "complex f32";
  info["spectrum_bytes"] =
      header.is_double ? fourier::spectrum_bytes<double>(s) : fourier::spectrum_bytes<float>(s);
  info["attributes"] = s.attributes;
  return info;
}

/// Options that ask for voxels, of a file that has none.
void warn_of_ignored(const std::string& path, const char* holds, const Options& o, cli::Record& record) {
  std::string words;
  const auto add = [&](const char* option, bool given) {
    if (given) words += (words.empty() ? "" : ", ") + std::string(option);
  };
  add("--checksum", o.checksum);
  add("--histogram", o.bins > 0);
  add("--array", !o.input.array.empty());
  add("--missing", o.input.missing.has_value());
  add("--volume", o.input.volume.has_value());
  if (words.empty()) return;
  record.warn(io::display_name(path) + ": holds " + holds + ", of which there is no " + words);
}

ordered_json examine_grid(const cli::GridInput& input, cli::Record& record) {
  ordered_json info = {{"file", io::display_name(input.path)}, {"holds", "curvilinear grid"}};
  info.update(cli::describe(input, cli::load(input, record), record));
  return info;
}

ordered_json examine(const std::string& path, const Options& o, cli::Record& record) {
  io::InputFile file(path);
  cli::GridInput grid = o.grid;
  grid.path = path;
  if (o.input.raw_dims.empty() && path != "-" && cli::is_grid(grid, file)) return examine_grid(grid, record);
  const bool vdb = o.input.raw_dims.empty() && io::is_vdb(file.peek(8));
  const std::string format(!o.input.raw_dims.empty() ? "raw" : vdb ? "OpenVDB" : io::volume_format(file));
  const std::int64_t bytes = file.size();
  ordered_json info = {{"file", io::display_name(path)}, {"format", format}};
  if (bytes >= 0) info["file_bytes"] = bytes;
  if (vdb && io::is_coefficients(file)) {
    record.input(path);
    const auto coefficients = record.timed("read", [&] { return io::read_coefficients(file); });
    info["holds"] = "wavelet coefficients";
    warn_of_ignored(path, "wavelet coefficients", o, record);
    info.update(std::visit([](const auto& d) { return describe(d); }, coefficients.decomposition));
    info["attributes"] = coefficients.attributes;
    return info;
  }
  if (o.input.raw_dims.empty() && io::is_spectrum(file)) {
    record.input(path);
    info["holds"] = "spectrum";
    warn_of_ignored(path, "a spectrum", o, record);
    info.update(describe(record.timed("read", [&] {
      const auto header = io::read_spectrum_header(file);
      if (bytes < 0) {  // of unknown size: whether all of it comes shows at the end
        file.skip(header.is_double ? fourier::spectrum_bytes<double>(header.info)
                                   : fourier::spectrum_bytes<float>(header.info));
      }
      return header;
    })));
    return info;
  }
  const auto volume = cli::load(file, o.input, record);
  info["holds"] = io::is_index(volume) ? "index volume" : "volume";
  record.count("voxels", volume.geometry().count());
  info.update(record.timed("figures", [&] { return describe(volume, o); }));
  return info;
}

void print_histogram(const ordered_json& histogram) {
  constexpr double kWidest = 50;  // characters
  const auto counts = histogram["counts"].get<std::vector<std::int64_t>>();
  const double low = histogram["min"], high = histogram["max"];
  const auto largest = static_cast<double>(*std::max_element(counts.begin(), counts.end()));
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const double from = low + (high - low) * static_cast<double>(b) / static_cast<double>(counts.size());
    const auto bar = static_cast<std::size_t>(kWidest * static_cast<double>(counts[b]) / largest + 0.5);
    std::printf("  %12.6g  %10lld  %s\n", from, static_cast<long long>(counts[b]),
                std::string(bar, '#').c_str());
  }
}

std::string one_line(const ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array() && !value.empty() && value[0].is_number()) {
    std::string text;
    for (const auto& x : value) text += (text.empty() ? "" : " ") + x.dump();
    return text;
  }
  if (value.is_array()) {
    std::string text;
    for (const auto& v : value) text += (text.empty() ? "(" : ", (") + one_line(v) + ")";
    return text;
  }
  return value.dump();
}

void print_text(const ordered_json& info) {
  std::printf("%s\n", info["file"].get<std::string>().c_str());
  for (const auto& [key, value] : info.items()) {
    if (key == "file" || key == "histogram" || key == "attributes" || key == "subbands" || key == "blocks") {
      continue;
    }
    std::printf("  %-20s %s\n", key.c_str(), one_line(value).c_str());
  }
  if (info.contains("subbands")) {
    for (const auto& band : info["subbands"]) {
      std::printf("  %-20s %s, %s of %s kept\n", band["name"].get<std::string>().c_str(),
                  one_line(band["dims"]).c_str(), band["kept"].dump().c_str(), band["total"].dump().c_str());
    }
  }
  if (info.contains("blocks")) {
    std::size_t number = 0;
    for (const auto& block : info["blocks"]) {
      std::printf("  block %zu\n", number++);
      for (const auto& [key, value] : block.items()) {
        std::printf("    %-18s %s\n", key.c_str(), one_line(value).c_str());
      }
    }
  }
  for (const auto& [key, value] : info["attributes"].items()) {
    std::printf("  %-20s %s\n", key.c_str(), one_line(value).c_str());
  }
  if (info.contains("histogram")) print_histogram(info["histogram"]);
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{
      "Says what files hold: format, size, type, geometry, range, mean, provenance; of wavelet coefficients "
      "the subbands, of spectra padding, filter and model, of curvilinear grids bounds, Jacobian, folded and "
      "collapsed cells.\n"
      "--checksum adds a hash of the content, which does not depend on the file format."};
  app.add_option("files", o.files,
                 "Volumes, index volumes, coefficients or spectra (.nrrd .nhdr .mha .mhd .vti .vtk .nii .vdb "
                 "or raw), curvilinear grids (.vts, PLOT3D .xyz); - is standard input, not for grids")
      ->required()
      ->group("Files");
  o.input.index_volumes = true;
  cli::add_volume_options(app, o.input);
  cli::add_grid_options(app, o.grid);
  app.add_option("--histogram", o.bins, "Count the voxels in this many equal intervals of the range; 0: none")
      ->check(CLI::Range(0, 65536))
      ->capture_default_str()
      ->group("Figures");
  app.add_flag("--json", o.json, "JSON: an object, or for several files an array of them")->group("Figures");
  return cli::run(
      app, {.name = "vol-info", .example = "vol-phantom marschner-lobb -o - | vol-info - --histogram 16"},
      argc, argv, [&](cli::Record& record) {
        o.checksum = app.get_option("--checksum")->count() > 0;
        ordered_json all = ordered_json::array();
        for (const auto& path : o.files) {
          all.push_back(examine(path, o, record));
          if (!o.json) print_text(all.back());
        }
        const auto replace = ordered_json::error_handler_t::replace;  // attributes may be no UTF-8
        if (o.json)
          std::printf("%s\n", (all.size() == 1 ? all[0] : all).dump(2, ' ', false, replace).c_str());
        return 0;
      });
}
