#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

// What the comparing tools share: figures that may be infinite or undefined, and the thresholds they are held
// to.
namespace vol::cli {

/// A figure as JSON: a number, or, since JSON has none, the strings "inf", "-inf" and "nan".
[[nodiscard]] nlohmann::json figure(double value);

/// A figure for reading: six significant digits, "inf", "-inf" or "-" where it is undefined.
[[nodiscard]] std::string figure_text(double value);

struct Threshold {
  std::string metric;
  double value;
};

/// "METRIC=VALUE" with a metric of the list; infinity is a value, NaN is not. Throws vol::Error naming the
/// option.
[[nodiscard]] Threshold parse_threshold(const std::string& option, const std::string& text,
                                        const std::vector<std::string>& metrics);

}  // namespace vol::cli
