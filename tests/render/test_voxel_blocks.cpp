#include "render/voxel_blocks.h"

#include <gtest/gtest.h>

#include <cstring>
#include <type_traits>

#include "base/error.h"
#include "packet_oracle.h"
#include "render/caster.h"

namespace vol::render {
namespace {

/// More than a block along every axis, not a multiple of one along any.
constexpr Dims kDims = {131, 19, 27};

template <class T>
class VoxelBlocksOf : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::uint16_t, std::int16_t, float>;
TYPED_TEST_SUITE(VoxelBlocksOf, Types);

/// Voxels that tell where they are.
template <class T>
T at_place(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<T>((i * 7 + j * 131 + k * 17 + (i * j * k) % 5) % 30000);
}

template <class T>
volume::Volume placed(const Dims& dims) {
  volume::GridGeometry geometry;
  geometry.dims = dims;
  volume::Grid<T> grid{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) grid(i, j, k) = at_place<T>(i, j, k);
    }
  }
  return {std::move(grid), {}};
}

TYPED_TEST(VoxelBlocksOf, EveryVoxelIsWhereTheFormulaSaysAndItsNeighbourAlongXNextToIt) {
  using T = TypeParam;
  for (const Dims& dims : {kDims, Dims{2, 2, 2}, Dims{64, 8, 8}, Dims{65, 9, 8}, Dims{16, 33, 7}}) {
    volume::Volume v = placed<T>(dims);
    const VoxelBlocks blocks(v);
    EXPECT_TRUE(std::get<volume::Grid<T>>(v.grid).voxels.empty());
    EXPECT_EQ(v.geometry().dims, dims);
    const BlockStrides& s = blocks.strides();
    constexpr auto kBytes = std::int64_t{sizeof(T)};
    const std::int64_t unit = kBytes == 4 ? 4 : 1, size = kBytes / unit, width = 64 / kBytes;
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          const std::int64_t at = i * size + (j + 8 * k) * s.pitch + i / width * s.beyond[0] +
                                  j / 8 * s.beyond[1] + k / 8 * s.beyond[2];
          T pair[2];
          std::memcpy(pair, static_cast<const char*>(blocks.data()) + at * unit, sizeof pair);
          ASSERT_EQ(pair[0], at_place<T>(i, j, k)) << i << ' ' << j << ' ' << k;
          if (i + 1 < dims[0]) {
            ASSERT_EQ(pair[1], at_place<T>(i + 1, j, k)) << i << ' ' << j << ' ' << k;
          }
        }
      }
    }
  }
}

/// Of pictures large enough that rays meet every kind of border between blocks.
RenderOptions options_of(Quadrature rule = Quadrature::trapezoid) {
  RenderOptions options = packet_options(rule);
  options.width = 121;
  options.height = 97;
  return options;
}

/// The picture of a scene from rows and from blocks: the same to the last bit.
void expect_same_from_blocks(volume::Volume v, const Scene& scene, const RenderOptions& options,
                             const index::IndexVolume* index = nullptr) {
  Caster caster(v, scene, options, {.index = index});
  const RenderResult rows = caster.cast();
  ASSERT_STREQ(rows.caster, "packets");
  ASSERT_GT(rows.counts.samples, 1000);
  ASSERT_TRUE(caster.lay_out_in_blocks(v));
  volume::visit(v, [](const auto& grid) { EXPECT_TRUE(grid.voxels.empty()); });
  const RenderResult blocks = caster.cast();
  expect_same_bits(rows.image, blocks.image, true);
  EXPECT_TRUE(caster.lay_out_in_blocks(v)) << "they are already";
  EXPECT_EQ(rows.counts.samples, blocks.counts.samples);
  EXPECT_EQ(rows.counts.skipped, blocks.counts.skipped);
}

TYPED_TEST(VoxelBlocksOf, GiveThePicturesThatRowsGive) {
  const double full = std::is_same_v<TypeParam, std::uint8_t> ? 255 : 3000;
  const auto v = packet_volume<TypeParam>(full, kDims);
  for (const Quadrature rule :
       {Quadrature::rectangle, Quadrature::trapezoid, Quadrature::preintegrated, Quadrature::split}) {
    SCOPED_TRACE(static_cast<int>(rule));
    Scene scene = packet_scene(full);
    expect_same_from_blocks(v, scene, options_of(rule));
    scene.shading = Shading{};
    expect_same_from_blocks(v, scene, options_of(rule));
  }
  RenderOptions options = options_of();
  options.step_tolerance = 1e-3;
  expect_same_from_blocks(v, packet_scene(full), options);
  options = options_of();
  options.reconstruction = volume::Reconstruction::nearest;
  expect_same_from_blocks(v, packet_scene(full), options);
  for (const Model model : {Model::xray, Model::mip}) {
    Scene scene = packet_scene(full);
    scene.model = model;
    expect_same_from_blocks(v, scene, options_of(Quadrature::trapezoid));
  }
}

TEST(VoxelBlocks, GiveThePicturesThatRowsGiveWithAnIndex) {
  const auto v = packet_volume<std::uint8_t>(255, kDims);
  const RenderOptions options = options_of();
  index::IndexVolume index(kDims, 2, options.step);
  Rng rng(3);
  for (std::int64_t k = 0; k < index.dims()[2]; ++k) {
    for (std::int64_t j = 0; j < index.dims()[1]; ++j) {
      for (std::int64_t i = 0; i < index.dims()[0]; ++i)
        index.set_entry(i, j, k, static_cast<int>(rng.below(4)));
    }
  }
  expect_same_from_blocks(v, packet_scene(255), options, &index);
}

TEST(VoxelBlocks, GiveThePicturesThatRowsGiveOfAConvertedCopy) {
  // Packets read voxels of 8 bytes from a copy in floats.
  expect_same_from_blocks(packet_volume<double>(1, kDims), packet_scene(1), options_of());
}

TEST(VoxelBlocks, AreNotMadeWherePacketsDoNotReadThem) {
  const auto stays = [](volume::Volume v, const RenderOptions& options, const CasterOptions& with) {
    const Scene scene = packet_scene(255);
    Caster caster(v, scene, options, with);
    EXPECT_FALSE(caster.lay_out_in_blocks(v));
    volume::visit(v, [](const auto& grid) {
      EXPECT_EQ(static_cast<std::int64_t>(grid.voxels.size()), grid.geometry.count());
    });
    EXPECT_GT(caster.cast().counts.samples, 0);
  };
  const auto v = packet_volume<std::uint8_t>(255, {21, 17, 19});
  stays(v, options_of(), {.packets = false});
  RenderOptions options = options_of();
  options.max_error = 1e-2;
  stays(v, options, {});
  options = options_of();
  options.reconstruction = volume::Reconstruction::catmull_rom;
  stays(v, options, {});
  stays(packet_volume<std::uint8_t>(255, {21, 1, 19}), options_of(), {});
}

TEST(VoxelBlocks, TakeThePlaceOfVoxelsWhosePagesAreGivenBack) {
  // Slices of several pages: where the voxels were they can be read no more.
  expect_same_from_blocks(packet_volume<std::uint8_t>(255, {131, 130, 21}), packet_scene(255), options_of());
}

TEST(VoxelBlocks, GiveThePicturesThatRowsGiveWithFewerRays) {
  RenderOptions options = options_of();
  options.image_step = 4;
  options.image_tolerance = 0.01;
  expect_same_from_blocks(packet_volume<std::uint16_t>(3000, kDims), packet_scene(3000), options);
}

/// A volume of that type and dims without its voxels.
template <class T>
volume::Volume empty(const Dims& dims) {
  volume::GridGeometry geometry;
  geometry.dims = dims;
  return {volume::Grid<T>{geometry, {}}, {}};
}

TEST(VoxelBlocks, FitWhereOffsetsHoldThemAndFewPlacesStayEmpty) {
  // 64 x 8 x 8 bytes take 4160: 2^31 bytes are 516222.1 blocks. 16 x 8 x 8 floats 1088 places: 1973790.1.
  EXPECT_TRUE(fits_blocks(empty<std::uint8_t>({64, 8, 8 * std::int64_t{516222}})));
  EXPECT_FALSE(fits_blocks(empty<std::uint8_t>({64, 8, 8 * std::int64_t{516223}})));
  EXPECT_TRUE(fits_blocks(empty<float>({16, 8, 8 * std::int64_t{1973790}})));
  EXPECT_FALSE(fits_blocks(empty<float>({16, 8, 8 * std::int64_t{1973791}})));
  EXPECT_TRUE(fits_blocks(empty<std::uint8_t>({512, 512, 73})));
  EXPECT_FALSE(fits_blocks(empty<std::uint8_t>({8192, 8192, 2})));
}

TEST(VoxelBlocks, AreRefusedOfFlatVolumesOtherTypesAndOthersVolumes) {
  volume::Volume flat = packet_volume<std::uint8_t>(255, {21, 1, 19}),
                 wide = packet_volume<double>(1, {5, 5, 5});
  EXPECT_FALSE(fits_blocks(flat));
  EXPECT_THROW(VoxelBlocks{flat}, Error);
  EXPECT_FALSE(fits_blocks(wide));
  EXPECT_THROW(VoxelBlocks{wide}, Error);
  const volume::Volume one = packet_volume<std::uint8_t>(255);
  volume::Volume other = packet_volume<std::uint8_t>(255);
  Caster caster(one, packet_scene(255), options_of(), {});
  EXPECT_THROW(caster.lay_out_in_blocks(other), Error);
}

}  // namespace
}  // namespace vol::render
