#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../io/files.h"
#include "base/error.h"
#include "curvilinear/phantom.h"
#include "io/grid.h"

namespace vol::io {
namespace {

TEST(Vts, ComesBackToTheBit) {
  const Folder folder;
  auto grid = curvilinear::make_phantom("delta-wing", {4, 3, 5}, "marschner-lobb", 1);
  auto& block = grid.blocks[0];
  block.arrays.push_back({"a <second> one", std::vector<double>(block.points.size(), 1e-30)});
  block.hidden.assign(block.points.size(), 0);
  block.hidden[7] = 1;
  EXPECT_TRUE(write_grid(folder / "a.vts", grid).empty());
  const auto back = read_grid(folder / "a.vts");
  ASSERT_EQ(back.blocks.size(), 1U);
  EXPECT_EQ(back.blocks[0].dims, block.dims);
  EXPECT_EQ(back.blocks[0].points, block.points);
  EXPECT_EQ(back.blocks[0].hidden, block.hidden);
  EXPECT_EQ(back.attributes, grid.attributes);
  ASSERT_EQ(back.blocks[0].arrays.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(back.blocks[0].arrays[n].name, block.arrays[n].name);
    EXPECT_EQ(back.blocks[0].arrays[n].values, block.arrays[n].values);
  }
}

TEST(Vts, TextAndVectorsAreRead) {
  const Folder folder;
  std::string points, vectors;
  for (int n = 0; n < 8; ++n) {
    points += std::to_string(n & 1) + " " + std::to_string(n >> 1 & 1) + " " + std::to_string(n >> 2) + "\n";
    vectors += std::to_string(n) + " 0.5 -" + std::to_string(n) + " ";
  }
  const std::string head =
      "<VTKFile type=\"StructuredGrid\"><StructuredGrid WholeExtent=\"3 4 0 1 0 1\"><Piece Extent=\"3 4 0 1 "
      "0 1\">";
  const std::string data =
      "<PointData><DataArray type=\"Float32\" Name=\"v\" NumberOfComponents=\"3\" format=\"ascii\">" +
      vectors + "</DataArray></PointData>";
  const std::string positions =
      "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">" + points +
      "</DataArray></Points>";
  const std::string tail = "</Piece></StructuredGrid></VTKFile>";
  const auto grid = read_grid(folder.write("a.vts", head + data + positions + tail));
  EXPECT_EQ(grid.blocks[0].points[5], Vec3(1, 0, 1));
  ASSERT_NE(grid.blocks[0].find("v.z"), nullptr);
  EXPECT_EQ(grid.blocks[0].find("v.z")->values[6], -6);
  EXPECT_THROW((void)read_grid(folder.write("b.vts", head + data + tail)), Error);
  EXPECT_THROW((void)read_grid(folder.write("c.vts", head + positions.substr(0, positions.size() - 30))),
               Error);
  EXPECT_THROW((void)read_grid(folder.write("d.vts", "<VTKFile type=\"ImageData\"></VTKFile>")), Error);
}

TEST(Vts, WhatItCannotHoldIsRefused) {
  const Folder folder;
  auto grid = curvilinear::make_phantom("twisted-box", {2, 2, 2}, "ramp", 1);
  EXPECT_THROW((void)write_grid(folder / "a.vtu", grid), Error);
  grid.blocks.push_back(grid.blocks[0]);
  EXPECT_THROW((void)write_grid(folder / "a.vts", grid), Error);
}

TEST(Vts, CutShortIsRefused) {
  const Folder folder;
  const auto path = folder / "a.vts";
  (void)write_grid(path, curvilinear::make_phantom("twisted-box", {3, 3, 3}, "ramp", 1));
  const std::string whole = bytes_of(path);
  for (const std::size_t n : {whole.size() / 4, whole.size() / 2, whole.size() - 200}) {
    EXPECT_THROW((void)read_grid(folder.write("cut.vts", whole.substr(0, n))), Error) << n;
  }
}

}  // namespace
}  // namespace vol::io
