#include "cli/threshold.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace vol::cli {

nlohmann::json figure(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

std::string figure_text(double value) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

Threshold parse_threshold(const std::string& option, const std::string& text,
                          const std::vector<std::string>& metrics) {
  const std::size_t equals = text.find('=');
  Threshold threshold{text.substr(0, equals), 0};
  const std::string value = equals == std::string::npos ? "" : text.substr(equals + 1);
  std::string names;
  for (const auto& name : metrics) names += (names.empty() ? "" : ", ") + name;
  if (std::find(metrics.begin(), metrics.end(), threshold.metric) == metrics.end()) {
    throw Error(option + " " + text + ": expected METRIC=VALUE with one of " + names);
  }
  const auto parsed = std::from_chars(value.data(), value.data() + value.size(), threshold.value);
  if (value.empty() || parsed.ec != std::errc() || parsed.ptr != value.data() + value.size()) {
    throw Error(option + " " + text + ": expected a number after the equals sign");
  }
  if (std::isnan(threshold.value))
    throw Error(option + " " + text + ": nothing is above or below NaN; give a number");
  return threshold;
}

Thresholds::Thresholds(const ThresholdOptions& options, const std::vector<std::string>& smaller,
                       const std::vector<std::string>& larger) {
  for (const auto& text : options.above) above_.push_back(parse_threshold("--fail-above", text, smaller));
  for (const auto& text : options.below) below_.push_back(parse_threshold("--fail-below", text, larger));
}

bool Thresholds::name(const std::string& metric) const {
  const auto is_it = [&](const Threshold& t) { return t.metric == metric; };
  return std::any_of(above_.begin(), above_.end(), is_it) || std::any_of(below_.begin(), below_.end(), is_it);
}

bool Thresholds::hold(const std::function<double(const std::string& metric)>& figure,
                      const Record& record) const {
  bool good = true;
  const auto check = [&](const Threshold& t, bool above) {
    const double value = figure(t.metric);
    if (above ? value <= t.value : value >= t.value) return;
    good = false;
    record.say(std::isnan(value) ? t.metric + " is undefined"
                                 : t.metric + " " + figure_text(value) + " is not at " +
                                       (above ? "most " : "least ") + figure_text(t.value));
  };
  for (const auto& t : above_) check(t, true);
  for (const auto& t : below_) check(t, false);
  return good;
}

}  // namespace vol::cli
