#pragma once
#include <Imath/half.h>

#include <cstdint>
#include <string_view>

namespace vol::volume {

/// Voxel types stay what the file has: a volume is not widened unless an algorithm needs it.
enum class VoxelType { i8, u8, i16, u16, i32, u32, f16, f32, f64 };

using half = Imath::half;

/// Calls f.template operator()<T>() with the C++ type of a voxel type.
template <class F>
decltype(auto) dispatch(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::i8: return f.template operator()<std::int8_t>();
    case VoxelType::u8: return f.template operator()<std::uint8_t>();
    case VoxelType::i16: return f.template operator()<std::int16_t>();
    case VoxelType::u16: return f.template operator()<std::uint16_t>();
    case VoxelType::i32: return f.template operator()<std::int32_t>();
    case VoxelType::u32: return f.template operator()<std::uint32_t>();
    case VoxelType::f16: return f.template operator()<half>();
    case VoxelType::f32: return f.template operator()<float>();
    case VoxelType::f64: break;
  }
  return f.template operator()<double>();
}

/// Short names: i8 u8 i16 u16 i32 u32 f16 f32 f64.
[[nodiscard]] std::string_view name(VoxelType type);
/// Inverse of name(); throws vol::Error listing the names.
[[nodiscard]] VoxelType voxel_type_from_name(std::string_view name);
[[nodiscard]] std::size_t size_in_bytes(VoxelType type);
[[nodiscard]] bool is_floating_point(VoxelType type);

}  // namespace vol::volume
