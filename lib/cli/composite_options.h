#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "cli/record.h"
#include "io/scene.h"
#include "render/wavelet_composite.h"

namespace vol::cli {

inline constexpr double kCompositeTolerance = 1e-6;

/// Self-occlusion of a wavelet expansion on the command line. Target vol_cli_composite.
struct CompositeOptions {
  std::filesystem::path transfer;  ///< --transfer
  std::optional<double> extinction;
  std::optional<std::string> negative, linearised;
  std::optional<double> tolerance;  ///< --tolerance; kCompositeTolerance where it is not given
};

/// Declares them, --transfer among the files.
void add_composite(CLI::App& app, CompositeOptions& options);

/// What was asked for, with the scene's transfer function replaced by --transfer; the file is read, and noted
/// among the inputs. \throws vol::Error on what does not go together, and on any of it without the model
[[nodiscard]] render::CompositeOptions resolve(const CompositeOptions& options, io::SceneFile& scene,
                                               Record& record);

/// What a picture cost and left out, and warns where the tolerance was not reached.
void report(const render::RenderResult& result, const render::CompositeCounts& counts,
            const CompositeOptions& options, Record& record);

}  // namespace vol::cli
