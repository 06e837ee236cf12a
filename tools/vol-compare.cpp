// vol-compare: error of one volume against another.
//   vol-compare rebuilt.nrrd original.nrrd
//   vol-compare rebuilt.nrrd original.nrrd --json --fail-above relative_l2=1e-6
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/run.h"
#include "cli/threshold.h"
#include "cli/volume_input.h"
#include "io/file.h"
#include "volume/compare.h"

namespace {

using nlohmann::json;
using vol::volume::VolumeError;

struct Metric {
  const char* name;
  bool less_is_better;
  double (*of)(const VolumeError& error);
};

const std::vector<Metric> kMetrics{
    {"mse", true, [](const VolumeError& e) { return e.mse; }},
    {"rmse", true, [](const VolumeError& e) { return e.rmse; }},
    {"rmse_byte", true, [](const VolumeError& e) { return e.rmse_byte; }},
    {"mae", true, [](const VolumeError& e) { return e.mae; }},
    {"max", true, [](const VolumeError& e) { return e.maximum; }},
    {"psnr", false, [](const VolumeError& e) { return e.psnr; }},
    {"relative_l2", true, [](const VolumeError& e) { return e.relative_l2; }},
    {"differing", true, [](const VolumeError& e) { return static_cast<double>(e.differing); }},
};

const Metric& metric(const std::string& name) {
  for (const auto& m : kMetrics) {
    if (m.name == name) return m;
  }
  throw vol::Error("unknown metric " + name);
}

std::vector<std::string> metric_names(bool less_is_better) {
  std::vector<std::string> names;
  for (const auto& m : kMetrics) {
    if (m.less_is_better == less_is_better) names.emplace_back(m.name);
  }
  return names;
}

struct Options {
  std::string tested, reference;
  vol::cli::VolumeInput input;
  vol::cli::ThresholdOptions thresholds;
  bool json = false, same_geometry = false;
};

json to_json(const VolumeError& error, const vol::Dims& dims, const std::vector<std::string>& geometry) {
  json result;
  for (const auto& m : kMetrics) result[m.name] = vol::cli::figure(m.of(error));
  result["differing"] = error.differing;
  result["max_at"] = error.maximum_at[0] < 0 ? json() : json(error.maximum_at);
  result["dims"] = dims;
  result["reference_range"] = {error.reference_range.min, error.reference_range.max};
  result["geometry_differences"] = geometry;
  return result;
}

void print_table(const VolumeError& error, const std::vector<std::string>& geometry) {
  for (const auto& m : kMetrics)
    std::printf("%-12s %s\n", m.name, vol::cli::figure_text(m.of(error)).c_str());
  if (error.maximum_at[0] >= 0) {
    std::printf("%-12s %lld,%lld,%lld\n", "max at", static_cast<long long>(error.maximum_at[0]),
                static_cast<long long>(error.maximum_at[1]), static_cast<long long>(error.maximum_at[2]));
  }
  std::printf("%-12s %.9g to %.9g\n", "range", error.reference_range.min, error.reference_range.max);
  for (const auto& difference : geometry) std::printf("%-12s %s\n", "geometry", difference.c_str());
}

int compare_volumes(const Options& options, vol::cli::Record& record) {
  const vol::cli::Thresholds thresholds(options.thresholds, metric_names(true), metric_names(false));
  if (options.tested == "-" && options.reference == "-")
    throw vol::Error("only one volume can come from standard input");
  const auto tested = vol::cli::load(options.tested, options.input, record);
  const auto reference = vol::cli::load(options.reference, options.input, record);
  const auto& dims = reference.geometry().dims;
  if (tested.geometry().dims != dims) {
    const auto name = [](const vol::Dims& d) {
      return std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" + std::to_string(d[2]);
    };
    throw vol::Error(vol::io::display_name(options.tested) + " is " + name(tested.geometry().dims) + ", " +
                     vol::io::display_name(options.reference) + " is " + name(dims) +
                     ": the dims must be the same");
  }
  const VolumeError error =
      record.repeated("compare", [&] { return vol::volume::compare(tested, reference); });
  const auto geometry = vol::volume::geometry_differences(tested.geometry(), reference.geometry());

  json result = to_json(error, dims, geometry);
  record.error("volume", result);
  record.count("voxels", reference.geometry().count());
  bool good = thresholds.hold([&](const std::string& name) { return metric(name).of(error); }, record);
  if (options.same_geometry && !geometry.empty()) {
    record.say("the geometry differs: " + geometry.front());
    good = false;
  }
  if (thresholds.any() || options.same_geometry) {
    result["pass"] = good;
    record.result("pass", good);
  }
  if (options.json) {
    std::printf("%s\n", result.dump(2).c_str());
  } else {
    print_table(error, geometry);
  }
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{
      "Error of a volume against a reference of the same dims, voxel by voxel: MSE, RMSE, MAE, maximum, "
      "PSNR, relative L2.\n"
      "Byte scale and PSNR refer to the reference's range: 255/(max - min), peak max - min. Types may "
      "differ."};
  app.add_option(
         "volume", o.tested,
         "The volume under test (.nrrd .nhdr .mha .mhd .vti .vtk .nii .vdb or raw); - for standard input")
      ->required()
      ->group("Files");
  app.add_option("reference", o.reference, "The truth it is held against; same dims")
      ->required()
      ->group("Files");
  vol::cli::add_volume_options(app, o.input);
  app.add_flag("--json", o.json,
               "JSON instead of a table; what is infinite or undefined stands as \"inf\", \"-inf\", \"nan\"")
      ->group("Figures");
  app.add_option("--fail-above", o.thresholds.above,
                 "Exit with 1 unless METRIC (mse, rmse, rmse_byte, mae, max, relative_l2, differing) is at "
                 "most VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
  app.add_option("--fail-below", o.thresholds.below,
                 "Exit with 1 unless METRIC (psnr, in dB) is at least VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
  app.add_flag("--same-geometry", o.same_geometry,
               "Exit with 1 too where spacing, origin, direction or space differ (they are always reported)")
      ->group("Pass or fail");
  return vol::cli::run(app,
                       {.name = "vol-compare",
                        .example = "vol-compare rebuilt.nrrd original.nrrd --fail-above relative_l2=1e-6",
                        .repeats = true},
                       argc, argv, [&](vol::cli::Record& record) { return compare_volumes(o, record); });
}
