#pragma once
#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "transfer/bezier.h"

namespace vol::io {

inline constexpr std::int64_t kLargestYaml = 1 << 20;
/// A YAML file of at most so many bytes; \throws vol::Error naming the file and the line of a syntax error.
[[nodiscard]] YAML::Node load_yaml(const std::filesystem::path& path, std::int64_t most = kLargestYaml);
/// A channel of an sRGB colour as linear light (IEC 61966-2-1).
[[nodiscard]] double linear_light(double v);
/// The map of a transfer function (io/scene.h says which keys).
[[nodiscard]] transfer::TransferFunction parse_transfer_function(const YAML::Node& node);

/// The curves of such a map, nothing where it has none.
[[nodiscard]] std::optional<transfer::BezierTransfer> parse_bezier(const YAML::Node& node);

}  // namespace vol::io
