#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "cli/record.h"
#include "fit/samples.h"
#include "volume/volume.h"

namespace vol::cli {

/// The option group of what add_fit_target() declares besides the file.
inline constexpr const char* kFitTargetGroup = "Target";

/// What a transfer curve is to come close to, on the command line. Target vol_cli_fit.
struct FitTargetOptions {
  std::filesystem::path file;        ///< transfer function (.yaml, .json) or profile (.csv)
  std::vector<std::string> bands;    ///< --band
  std::vector<std::string> colours;  ///< --band-colours
};

void add_fit_target(CLI::App& app, FitTargetOptions& options);

/// What one curve is fitted to.
struct FitTarget {
  std::string name;
  Vec3 colour{1, 1, 1};
  std::function<double(double)> weight;  ///< of a data value
};

/// The targets of a run, and the values that they are about.
struct FitTargets {
  std::vector<FitTarget> curves;
  volume::Range range{0, 1};
};

/// Reads the file or the bands; a file is noted among the record's inputs. \throws vol::Error unless there is
/// one of both, on bands and colours that are none, and as the readers do
[[nodiscard]] FitTargets fit_targets(const FitTargetOptions& options, Record& record);

/// \throws vol::Error where no sample lies in some band: it would be fitted by nothing; more often it is a
/// wrong number.
void require_samples(const FitTargetOptions& options, const fit::Samples& samples);

}  // namespace vol::cli
