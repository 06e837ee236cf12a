#include "io/index.h"

#include <algorithm>
#include <sstream>

#include "base/checked.h"
#include "io/header_text.h"
#include "io/volume.h"

namespace vol::io {
namespace {

constexpr const char* kDims = "precis.index.dims";
constexpr const char* kReduction = "precis.index.reduction";
constexpr const char* kDistance = "precis.index.standard_distance";

const std::string& required(const volume::Volume& volume, const char* key) {
  const auto found = volume.attributes.find(key);
  if (found == volume.attributes.end()) throw Error(std::string("index volume without the key ") + key);
  return found->second;
}

template <class T>
T parsed(const volume::Volume& volume, const char* key) {
  std::istringstream text(required(volume, key));
  T value{};
  if (!(text >> value))
    throw Error(std::string("index volume whose key ") + key + " is " + in_quotes(text.str()) +
                ", no number");
  return value;
}

index::IndexVolume unpack(const volume::Volume& volume) {
  if (!is_index(volume)) throw Error("is a volume, not an index volume; make one with vol-index");
  const auto* packed = std::get_if<volume::Grid<std::uint8_t>>(&volume.grid);
  if (packed == nullptr)
    throw Error("index volume of voxel type " + std::string(name(volume.voxel_type())) + ", not u8");
  Dims dims{};
  std::istringstream text(required(volume, kDims));
  if (!(text >> dims[0] >> dims[1] >> dims[2]))
    throw Error(std::string("index volume whose key ") + kDims + " holds no three numbers");
  (void)checked_count(dims);
  const int reduction = parsed<int>(volume, kReduction);
  const double distance = parsed<double>(volume, kDistance);
  if (reduction < 1 || !(distance > 0))
    throw Error("index volume with a reduction or distance that is not positive");
  // Sizes first: the index takes half a byte for each entry, and a hostile key must not ask for more than the
  // file has.
  const Dims stored = packed->dims();
  const Dims entries = {(dims[0] + reduction - 1) / reduction, (dims[1] + reduction - 1) / reduction,
                        (dims[2] + reduction - 1) / reduction};
  if (stored != Dims{(entries[0] + 1) / 2, entries[1], entries[2]}) {
    throw Error("index volume of " + std::to_string(stored[0]) + " x " + std::to_string(stored[1]) + " x " +
                std::to_string(stored[2]) + " bytes does not fit its key " + kDims + " " +
                in_quotes(required(volume, kDims)));
  }
  index::IndexVolume index(dims, reduction, distance);
  std::copy(packed->voxels.begin(), packed->voxels.end(), index.nibbles().begin());
  return index;
}

}  // namespace

void write_index(const std::filesystem::path& path, const index::IndexVolume& index,
                 const volume::GridGeometry& geometry, const std::map<std::string, std::string>& attributes) {
  volume::GridGeometry packed = geometry;
  packed.dims = {index.row_bytes(), index.dims()[1], index.dims()[2]};
  const double r = index.reduction();
  packed.spacing = Vec3(2 * r * geometry.spacing.x(), r * geometry.spacing.y(), r * geometry.spacing.z());
  volume::Volume volume;
  volume.grid = volume::Grid<std::uint8_t>{packed, {index.nibbles().begin(), index.nibbles().end()}};
  volume.attributes = attributes;
  volume.attributes[kKindKey] = kIndexKind;
  const Dims& dims = index.volume_dims();
  volume.attributes[kDims] =
      std::to_string(dims[0]) + " " + std::to_string(dims[1]) + " " + std::to_string(dims[2]);
  volume.attributes[kReduction] = std::to_string(index.reduction());
  volume.attributes[kDistance] = shortest(index.standard_distance());
  (void)write_volume(path, volume, {.format = is_standard_stream(path) ? "nrrd" : ""});
}

IndexFile read_index(const std::filesystem::path& path) {
  const volume::Volume volume = read_volume(path);
  try {
    return {unpack(volume), volume.attributes};
  } catch (const Error& error) {
    throw Error(display_name(path), error);
  }
}

volume::Volume unpack_index(const volume::Volume& packed) {
  const index::IndexVolume index = unpack(packed);
  volume::GridGeometry geometry = packed.geometry();
  geometry.dims = index.dims();
  geometry.spacing.x() /= 2;
  volume::Volume result = volume::allocate(volume::VoxelType::u8, geometry);
  auto& grid = std::get<volume::Grid<std::uint8_t>>(result.grid);
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i)
        grid(i, j, k) = static_cast<std::uint8_t>(index.entry(i, j, k));
    }
  }
  result.attributes = packed.attributes;
  for (const char* key : {kKindKey, kDims, kReduction}) result.attributes.erase(key);
  return result;
}

}  // namespace vol::io
