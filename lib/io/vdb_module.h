#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// Private to lib/io: OpenVDB behind two classes, so that it can stay outside the programs. Its libraries take
// 40 ms and 35 MB to load; libprecis_vdb.so brings them in when the first OpenVDB file is met (io/vdb.cpp).
// The module calls nothing of the program's libraries (headers only), so that either side links alone.
namespace vol::io {

/// Voxels from lower to upper, both inside.
struct VdbBox {
  std::array<std::int32_t, 3> lower{0, 0, 0};
  std::array<std::int32_t, 3> upper{-1, -1, -1};
  [[nodiscard]] bool empty() const { return upper[0] < lower[0]; }
};

/// Index to world, p' = p M with row vectors, as OpenVDB has it.
using VdbMatrix = std::array<std::array<double, 4>, 4>;

/// An OpenVDB file that was read. Grids are numbered from 0. Boxes that densify() is given hold all active
/// voxels of the grid.
class VdbArchive {
 public:
  virtual ~VdbArchive() = default;
  /// The file's metadata that are text.
  [[nodiscard]] virtual std::map<std::string, std::string> metadata() const = 0;
  [[nodiscard]] virtual std::size_t grid_count() const = 0;
  [[nodiscard]] virtual std::string name(std::size_t grid) const = 0;
  /// "float", "double", "vec3s" ...
  [[nodiscard]] virtual std::string value_type(std::size_t grid) const = 0;
  /// The box of active voxels; empty where there are none.
  [[nodiscard]] virtual VdbBox active_box(std::size_t grid) const = 0;
  /// Nothing where the transform is not linear.
  [[nodiscard]] virtual std::optional<VdbMatrix> index_to_world(std::size_t grid) const = 0;
  /// All voxels of the box, active or not, x fastest. The grid's value type has to be that of `to`.
  virtual void densify(std::size_t grid, const VdbBox& box, float* to) const = 0;
  virtual void densify(std::size_t grid, const VdbBox& box, double* to) const = 0;
};

/// Grids to be written together.
class VdbGrids {
 public:
  virtual ~VdbGrids() = default;
  /// Adds the samples of a box, x fastest, as a sparse grid; zeros are neither stored nor active. A matrix so
  /// small that OpenVDB takes it for singular becomes the identity.
  virtual void add(const std::string& name, const VdbBox& box, const float* samples,
                   const VdbMatrix* index_to_world) = 0;
  virtual void add(const std::string& name, const VdbBox& box, const double* samples,
                   const VdbMatrix* index_to_world) = 0;
  /// The file, with OpenVDB's random id.
  [[nodiscard]] virtual std::string file(const std::map<std::string, std::string>& metadata) const = 0;
};

/// What the module offers. `read` takes a whole file that check_vdb_structure() has passed; what fails is
/// thrown as std::exception.
struct VdbModule {
  std::unique_ptr<VdbArchive> (*read)(std::vector<std::byte>& file) = nullptr;
  std::unique_ptr<VdbGrids> (*grids)() = nullptr;
};

/// The module's one entry, found by dlsym. Its number goes up with every change of what is above, so that a
/// module of another version is refused.
using FillVdbModule = void (*)(VdbModule* module);
inline constexpr const char* kVdbModule = "libprecis_vdb.so";
inline constexpr const char* kVdbEntry = "precis_vdb_module_1";

}  // namespace vol::io
