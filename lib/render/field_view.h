#pragma once
#include <algorithm>

#include "volume/field_sampler.h"

namespace vol::render {

/// Any FieldSampler behind two function pointers, so that the casters are compiled once. Refers to the field,
/// which must live longer.
struct FieldView {
  const void* field = nullptr;
  double (*value_at)(const void*, const Vec3&) = nullptr;
  Vec3 (*gradient_at)(const void*, const Vec3&) = nullptr;
  volume::FieldBounds bounds;

  [[nodiscard]] double value(const Vec3& p) const { return value_at(field, p); }
  [[nodiscard]] Vec3 gradient(const Vec3& p) const { return gradient_at(field, p); }
};

template <volume::FieldSampler F>
[[nodiscard]] FieldView view_of(const F& field) {
  return {&field, [](const void* f, const Vec3& p) { return double(static_cast<const F*>(f)->value(p)); },
          [](const void* f, const Vec3& p) { return Vec3(static_cast<const F*>(f)->gradient(p)); },
          field.bounds()};
}

}  // namespace vol::render
