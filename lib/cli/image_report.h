#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "image/metrics.h"

// What is said of an image's error: which figures, as JSON, as a table. Target vol_cli_image.
namespace vol::cli {

struct ImageMetric {
  std::string name;
  bool shown;  ///< without being asked for
  bool smaller_is_better;
  double (*of)(const image::ChannelError& error, double peak);
};

[[nodiscard]] const std::vector<ImageMetric>& image_metrics();
[[nodiscard]] std::vector<std::string> image_metric_names();
[[nodiscard]] std::vector<std::string> image_metric_names(bool smaller_is_better);

/// A metric's figure for all channels together. \throws vol::Error for one that is unknown
[[nodiscard]] double image_figure(const std::string& metric, const image::ImageError& error);

/// Those of these names; without names what is shown unasked, and the counts of NaN and infinity where `all`,
/// which may be nullptr, has any.
[[nodiscard]] std::vector<ImageMetric> chosen_image_metrics(const std::vector<std::string>& names,
                                                            const image::ChannelError* all);

/// Figures of all channels together and of each.
[[nodiscard]] nlohmann::json to_json(const image::ImageError& error, const std::vector<ImageMetric>& metrics);

/// The same for reading: a line a channel and one for all together.
[[nodiscard]] std::string table_of(const image::ImageError& error, const std::vector<ImageMetric>& metrics);

}  // namespace vol::cli
