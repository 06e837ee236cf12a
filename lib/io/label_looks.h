#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "render/labelled_medium.h"

namespace vol::io {

// clang-format off
/// Reads how labels look:
///     space: srgb                                    # of the colours; default linear
///     labels: [[1, 0.9, 0.4, 0.2, 0.05], ...]        # label, red, green, blue, opacity for one reference length
// clang-format on
/// Labels that are not listed are not seen. \throws vol::Error naming file and line: unknown or repeated key,
/// wrong form, a label twice or beyond 0 to 255, an opacity beyond 0 to 1, a negative colour
[[nodiscard]] std::vector<render::LabelLook> read_label_looks(const std::filesystem::path& path);

/// Without such a file: label 0 is not seen, 1 to 255 have an opacity of 0.05 and seven colours in turn.
[[nodiscard]] std::vector<render::LabelLook> default_label_looks();

[[nodiscard]] nlohmann::json to_json(const std::vector<render::LabelLook>& looks);

}  // namespace vol::io
