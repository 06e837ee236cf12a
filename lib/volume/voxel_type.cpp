#include "volume/voxel_type.h"

#include <array>
#include <string>

#include "base/error.h"

namespace vol::volume {
namespace {

constexpr std::array<std::string_view, 9> kNames = {"i8", "u8", "i16", "u16", "i32", "u32", "f16", "f32", "f64"};

}  // namespace

std::string_view name(VoxelType type) { return kNames[static_cast<std::size_t>(type)]; }

VoxelType voxel_type_from_name(std::string_view wanted) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == wanted) return static_cast<VoxelType>(i);
  }
  throw Error("voxel type '" + std::string(wanted) + "' is not one of i8 u8 i16 u16 i32 u32 f16 f32 f64");
}

std::size_t size_in_bytes(VoxelType type) {
  return dispatch(type, []<class T>() { return sizeof(T); });
}

bool is_floating_point(VoxelType type) {
  return type == VoxelType::f16 || type == VoxelType::f32 || type == VoxelType::f64;
}

}  // namespace vol::volume
