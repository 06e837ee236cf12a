#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cli/record.h"

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

/// The words of --fail-above and --fail-below.
struct ThresholdOptions {
  std::vector<std::string> above, below;
};

class Thresholds {
 public:
  /// \param smaller, larger  metrics that are better so: what --fail-above and --fail-below may name
  /// \throws vol::Error as parse_threshold()
  Thresholds(const ThresholdOptions& options, const std::vector<std::string>& smaller,
             const std::vector<std::string>& larger);

  [[nodiscard]] bool any() const { return !above_.empty() || !below_.empty(); }
  [[nodiscard]] bool name(const std::string& metric) const;
  /// Whether every one holds, of figures by their metric; says which do not. An undefined figure holds none:
  /// NaN in the data is a difference, and a structural similarity that does not exist cannot be asked for.
  [[nodiscard]] bool hold(const std::function<double(const std::string& metric)>& figure,
                          const Record& record) const;

 private:
  std::vector<Threshold> above_, below_;
};

}  // namespace vol::cli
