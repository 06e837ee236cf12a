#pragma once
#include <filesystem>
#include <string>

#include "cli/fvr.h"
#include "transfer/bezier.h"

// What the sources of vol_cli_fvr read out of the same words.
namespace vol::cli {

/// All views in one volume of grey pictures, uncompressed: for programs, and many a second.
[[nodiscard]] bool is_stack(const FvrOptions& o);
[[nodiscard]] bool is_png(const std::filesystem::path& output, const std::string& format);
/// 0 for auto. \throws vol::Error on what is neither that nor a positive number
[[nodiscard]] double given_exposure(const FvrOptions& o);
/// \throws vol::Error for a file of anything else
[[nodiscard]] transfer::BezierTransfer read_curves(const std::filesystem::path& path);

}  // namespace vol::cli
