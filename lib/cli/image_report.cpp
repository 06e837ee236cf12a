#include "cli/image_report.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/threshold.h"

namespace vol::cli {

using image::ChannelError;
using nlohmann::json;

const std::vector<ImageMetric>& image_metrics() {
  static const std::vector<ImageMetric> metrics{
      {"mse", true, true, [](const ChannelError& e, double) { return e.mse; }},
      {"rmse", true, true, [](const ChannelError& e, double) { return rmse(e); }},
      {"mse_byte", false, true, [](const ChannelError& e, double peak) { return mse_byte(e, peak); }},
      {"rmse_byte", true, true, [](const ChannelError& e, double peak) { return rmse_byte(e, peak); }},
      {"mae", true, true, [](const ChannelError& e, double) { return e.mae; }},
      {"max", true, true, [](const ChannelError& e, double) { return e.maximum; }},
      {"psnr", true, false, [](const ChannelError& e, double peak) { return psnr(e, peak); }},
      {"ssim", true, false, [](const ChannelError& e, double) { return e.ssim; }},
      {"nan", false, true,
       [](const ChannelError& e, double) { return static_cast<double>(e.nan_tested + e.nan_reference); }},
      {"infinite", false, true,
       [](const ChannelError& e, double) {
         return static_cast<double>(e.infinite_tested + e.infinite_reference);
       }},
  };
  return metrics;
}

std::vector<std::string> image_metric_names() {
  std::vector<std::string> names;
  for (const auto& m : image_metrics()) names.push_back(m.name);
  return names;
}

std::vector<std::string> image_metric_names(bool smaller_is_better) {
  std::vector<std::string> names;
  for (const auto& m : image_metrics()) {
    if (m.smaller_is_better == smaller_is_better) names.push_back(m.name);
  }
  return names;
}

double image_figure(const std::string& metric, const image::ImageError& error) {
  for (const auto& m : image_metrics()) {
    if (m.name == metric) return m.of(error.all, error.peak);
  }
  throw Error("unknown metric " + metric);
}

std::vector<ImageMetric> chosen_image_metrics(const std::vector<std::string>& names,
                                              const ChannelError* all) {
  std::vector<ImageMetric> chosen;
  for (const auto& m : image_metrics()) {
    const bool named = std::find(names.begin(), names.end(), m.name) != names.end();
    const bool telling = all != nullptr && (m.name == "nan" || m.name == "infinite") && m.of(*all, 1) > 0;
    if (names.empty() ? m.shown || telling : named) chosen.push_back(m);
  }
  return chosen;
}

namespace {

json figures(const ChannelError& error, double peak, const std::vector<ImageMetric>& metrics) {
  json result;
  for (const auto& m : metrics) result[m.name] = figure(m.of(error, peak));
  result["max_at"] = error.maximum_x < 0 ? json() : json{error.maximum_x, error.maximum_y};
  return result;
}

std::string cell(const char* form, const std::string& text) {
  char padded[64];
  std::snprintf(padded, sizeof padded, form, text.c_str());
  return padded;
}

}  // namespace

json to_json(const image::ImageError& error, const std::vector<ImageMetric>& metrics) {
  json result{{"peak", error.peak}, {"all", figures(error.all, error.peak, metrics)}};
  for (const auto& channel : error.channels)
    result["channels"][channel.name] = figures(channel, error.peak, metrics);
  return result;
}

std::string table_of(const image::ImageError& error, const std::vector<ImageMetric>& metrics) {
  std::string table = cell("%-10s", "channel");
  for (const auto& m : metrics) table += cell(" %12s", m.name);
  table += "  max at\n";
  const auto row = [&](const ChannelError& e, const std::string& channel) {
    table += e.name + std::string(e.name.size() < 10 ? 10 - e.name.size() : 0, ' ');
    for (const auto& m : metrics) table += cell(" %12s", figure_text(m.of(e, error.peak)));
    if (e.maximum_x >= 0) {
      table += "  " + std::to_string(e.maximum_x) + "," + std::to_string(e.maximum_y) + channel;
    }
    table += "\n";
  };
  for (const auto& channel : error.channels) row(channel, "");
  row(error.all, " " + error.all.maximum_channel);
  return table;
}

}  // namespace vol::cli
