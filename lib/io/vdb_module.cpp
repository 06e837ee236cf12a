// libprecis_vdb.so: the one translation unit that sees OpenVDB, whose headers take half a minute to compile.
#include "io/vdb_module.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <algorithm>
#include <istream>
#include <ostream>
#include <type_traits>

#include "io/vdb_bytes.h"

namespace vol::io {
namespace {

template <class T>
using GridOf = std::conditional_t<std::is_same_v<T, float>, openvdb::FloatGrid, openvdb::DoubleGrid>;
template <class T>
using DenseOf = openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ>;

void initialize() {
  static const bool done = [] {
    openvdb::initialize();
    return true;
  }();
  (void)done;
}

openvdb::CoordBBox box_of(const VdbBox& box) {
  return {openvdb::Coord(box.lower[0], box.lower[1], box.lower[2]),
          openvdb::Coord(box.upper[0], box.upper[1], box.upper[2])};
}

class Archive : public VdbArchive {
 public:
  explicit Archive(std::vector<std::byte>& file) {
    MemoryInput source(file);
    std::istream in(&source);
    in.exceptions(std::ios::failbit | std::ios::badbit |
                  std::ios::eofbit);  // OpenVDB itself reads on past the end
    openvdb::io::Stream stream(in, false);
    if (const auto grids = stream.getGrids()) grids_ = *grids;
    if (const auto metadata = stream.getMetadata()) metadata_ = *metadata;
    std::erase(grids_, nullptr);
  }

  std::map<std::string, std::string> metadata() const override {
    std::map<std::string, std::string> text;
    for (auto it = metadata_.beginMeta(); it != metadata_.endMeta(); ++it) {
      if (it->second && it->second->typeName() == openvdb::StringMetadata::staticTypeName())
        text[it->first] = static_cast<const openvdb::StringMetadata&>(*it->second).value();
    }
    return text;
  }
  std::size_t grid_count() const override { return grids_.size(); }
  std::string name(std::size_t grid) const override { return grids_.at(grid)->getName(); }
  std::string value_type(std::size_t grid) const override {
    const auto& base = *grids_.at(grid);  // only the standard tree of the type goes by its name
    if (base.isType<openvdb::FloatGrid>()) return "float";
    if (base.isType<openvdb::DoubleGrid>()) return "double";
    return base.valueType() == "float" || base.valueType() == "double" ? base.type() : base.valueType();
  }
  VdbBox active_box(std::size_t grid) const override {
    const openvdb::CoordBBox active = grids_.at(grid)->evalActiveVoxelBoundingBox();
    if (active.empty()) return {};
    VdbBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[static_cast<std::size_t>(axis)] = active.min()[axis];
      box.upper[static_cast<std::size_t>(axis)] = active.max()[axis];
    }
    return box;
  }
  std::optional<VdbMatrix> index_to_world(std::size_t grid) const override {
    const openvdb::math::Transform& transform = grids_.at(grid)->transform();
    if (!transform.isLinear()) return std::nullopt;
    const openvdb::Mat4R m = transform.baseMap()->getAffineMap()->getMat4();
    VdbMatrix matrix;
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t column = 0; column < 4; ++column)
        matrix[row][column] = m[static_cast<int>(row)][static_cast<int>(column)];
    }
    return matrix;
  }
  void densify(std::size_t grid, const VdbBox& box, float* to) const override { copy(grid, box, to); }
  void densify(std::size_t grid, const VdbBox& box, double* to) const override { copy(grid, box, to); }

 private:
  openvdb::GridPtrVec grids_;
  openvdb::MetaMap metadata_;

  template <class T>
  void copy(std::size_t grid, const VdbBox& box, T* to) const {
    DenseOf<T> dense(box_of(box), to);
    openvdb::tools::copyToDense(static_cast<const GridOf<T>&>(*grids_.at(grid)), dense);
  }
};

class Grids : public VdbGrids {
 public:
  void add(const std::string& name, const VdbBox& box, const float* samples,
           const VdbMatrix* index_to_world) override {
    put(name, box, samples, index_to_world);
  }
  void add(const std::string& name, const VdbBox& box, const double* samples,
           const VdbMatrix* index_to_world) override {
    put(name, box, samples, index_to_world);
  }
  std::string file(const std::map<std::string, std::string>& metadata) const override {
    openvdb::MetaMap meta;
    for (const auto& [key, value] : metadata) meta.insertMeta(key, openvdb::StringMetadata(value));
    MemoryOutput sink;
    std::ostream to(&sink);
    openvdb::io::Stream stream(to);
    stream.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    stream.write(grids_, meta);
    return std::move(sink.bytes);
  }

 private:
  openvdb::GridPtrVec grids_;

  template <class T>
  void put(const std::string& name, const VdbBox& box, const T* samples, const VdbMatrix* index_to_world) {
    auto grid = GridOf<T>::create(T{0});
    const DenseOf<T> dense(box_of(box), const_cast<T*>(samples));  // Dense only reads them here
    openvdb::tools::copyFromDense(dense, *grid, T{0});
    grid->setName(name);
    if (index_to_world != nullptr) {
      grid->setTransform(transform_of(*index_to_world));
      grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    }
    grids_.push_back(grid);
  }

  static openvdb::math::Transform::Ptr transform_of(const VdbMatrix& matrix) {
    openvdb::Mat4R m;
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t column = 0; column < 4; ++column)
        m[static_cast<int>(row)][static_cast<int>(column)] = matrix[row][column];
    }
    try {
      return openvdb::math::Transform::createLinearTransform(m);
    } catch (const openvdb::Exception&) {
      return openvdb::math::Transform::createLinearTransform(1.0);
    }
  }
};

}  // namespace
}  // namespace vol::io

extern "C" __attribute__((visibility("default"))) void precis_vdb_module_1(vol::io::VdbModule* module) {
  vol::io::initialize();
  module->read = [](std::vector<std::byte>& file) -> std::unique_ptr<vol::io::VdbArchive> {
    return std::make_unique<vol::io::Archive>(file);
  };
  module->grids = []() -> std::unique_ptr<vol::io::VdbGrids> { return std::make_unique<vol::io::Grids>(); };
}
