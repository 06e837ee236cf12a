#pragma once
#include <memory>

#include "render/field_view.h"
#include "volume/volume.h"

namespace vol::render {

/// A volume under a reconstruction kernel, as a field. Refers to the volume, which must live longer.
class GridField {
 public:
  GridField(const volume::Volume& volume, volume::Reconstruction reconstruction);
  [[nodiscard]] const FieldView& view() const { return view_; }

 private:
  std::shared_ptr<const void> sampler_;
  FieldView view_;
};

}  // namespace vol::render
