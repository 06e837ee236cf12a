#pragma once
#include <memory>
#include <span>
#include <string_view>

#include "volume/analytic_field.h"

// Private to lib/volume: the closed forms on [-1,1]^3, one .cpp a family.
namespace vol::volume {

class AnalyticForm {
 public:
  virtual ~AnalyticForm() = default;
  [[nodiscard]] virtual double value(const Vec3& p) const = 0;
  /// The values at (x[i], y, z), x equidistant, for forms that can tell a whole row faster than its points.
  virtual void row(std::span<const double> x, double y, double z, std::span<double> values) const {
    for (std::size_t i = 0; i < x.size(); ++i) values[i] = value({x[i], y, z});
  }
  [[nodiscard]] virtual Vec3 gradient(const Vec3& p) const = 0;
  [[nodiscard]] virtual Range range() const { return {0, 1}; }
};

using FormPointer = std::shared_ptr<const AnalyticForm>;

// Null where the name is not one of the family.
[[nodiscard]] FormPointer make_elementary_form(std::string_view name, const AnalyticOptions& options);
[[nodiscard]] FormPointer make_blob_form(std::string_view name, const AnalyticOptions& options);
[[nodiscard]] FormPointer make_shape_form(std::string_view name, const AnalyticOptions& options);
[[nodiscard]] FormPointer make_stepped_form(std::string_view name, const AnalyticOptions& options);
[[nodiscard]] FormPointer make_protein_form(std::string_view name, const AnalyticOptions& options);
[[nodiscard]] FormPointer make_texture_form(std::string_view name, const AnalyticOptions& options);

/// Of sample `index` of n along an axis of [-1,1]^3; an axis of one sample has it in the middle.
[[nodiscard]] inline double canonical_coordinate(std::int64_t index, std::int64_t n) {
  return n == 1 ? 0.0 : static_cast<double>(2 * index - (n - 1)) / static_cast<double>(n - 1);
}

}  // namespace vol::volume
