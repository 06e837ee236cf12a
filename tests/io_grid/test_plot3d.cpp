#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "../io/files.h"
#include "base/error.h"
#include "io/grid.h"

namespace vol::io {
namespace {

using ::testing::HasSubstr;

const std::vector<Dims> kBlocks = {{3, 4, 2}, {2, 2, 5}};

/// Value of variable v at point n of block b: each another, all exact in f32.
double number(std::size_t b, int v, std::int64_t n) {
  return 100.0 * static_cast<double>(b) + 10.0 * v + 0.125 * static_cast<double>(n) + 1;
}

struct Form {
  bool ascii = false, big = false, records = false, multi = false, iblank = false;
  int bits = 32;
  [[nodiscard]] std::string text() const {
    return std::string(ascii ? "ascii"
                       : big ? "big"
                             : "little") +
           (records ? " records" : "") + (multi ? " multi" : "") + (iblank ? " iblank" : "") + " " +
           std::to_string(bits);
  }
};

/// Writes PLOT3D from the manual's description, with code of its own.
class Writer {
 public:
  explicit Writer(const Form& form) : form_(form) {}
  void integers(const std::vector<std::int32_t>& values) {
    if (form_.ascii) {
      for (const auto v : values) chunk_ += std::to_string(v) + "\n ";
    } else {
      chunk_ += packed(values, form_.big);
    }
  }
  void real(double value) {
    if (form_.ascii) {
      chunk_ += std::to_string(value) + " ";
    } else if (form_.bits == 32) {
      chunk_ += packed<float>({static_cast<float>(value)}, form_.big);
    } else {
      chunk_ += packed<double>({value}, form_.big);
    }
  }
  void end_record() {
    const std::string mark =
        form_.records ? packed<std::int32_t>({static_cast<std::int32_t>(chunk_.size())}, form_.big) : "";
    bytes += mark + chunk_ + mark;
    chunk_.clear();
  }
  std::string bytes;

 private:
  Form form_;
  std::string chunk_;
};

std::size_t block_count(const Form& form) {
  return form.multi ? kBlocks.size() : 1;
}

std::string file(const Form& form, bool solution, bool overflow = false) {
  Writer w(form);
  const std::size_t blocks = block_count(form);
  if (form.multi) {
    w.integers({static_cast<std::int32_t>(blocks)});
    w.end_record();
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    for (const auto n : kBlocks[b]) w.integers({static_cast<std::int32_t>(n)});
  }
  if (overflow) w.integers({6, 0});
  w.end_record();
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::int64_t points = kBlocks[b][0] * kBlocks[b][1] * kBlocks[b][2];
    if (solution) {
      for (int n = 0; n < 4; ++n) w.real(0.5 + n);
      for (int n = 0; n < 11 && overflow; ++n) w.real(7);
      if (overflow) w.integers({1});
      w.end_record();
    }
    for (int v = 0; v < (overflow ? 6 : solution ? 5 : 3); ++v) {
      for (std::int64_t n = 0; n < points; ++n) w.real(number(b, v, n));
    }
    for (std::int64_t n = 0; n < points && form.iblank && !solution; ++n)
      w.integers({n == 5 ? 0 : n == 6 ? -2 : 1});
    w.end_record();
  }
  return w.bytes;
}

std::vector<Form> all_forms() {
  std::vector<Form> all;
  for (int n = 0; n < 64; ++n) {
    const Form f{(n & 32) != 0, (n & 1) != 0, (n & 2) != 0,
                 (n & 4) != 0,  (n & 8) != 0, (n & 16) != 0 ? 64 : 32};
    if (!f.ascii || (!f.big && !f.records && f.bits == 32)) all.push_back(f);
  }
  return all;
}

void expect_numbers(const curvilinear::Grid& grid, const Form& form) {
  ASSERT_EQ(grid.blocks.size(), block_count(form));
  for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
    const auto& block = grid.blocks[b];
    ASSERT_EQ(block.dims, kBlocks[b]);
    for (std::size_t n = 0; n < block.points.size(); ++n) {
      const auto at = static_cast<std::int64_t>(n);
      ASSERT_EQ(block.points[n], Vec3(number(b, 0, at), number(b, 1, at), number(b, 2, at)));
      for (int v = 0; v < 5 && !block.arrays.empty(); ++v) {
        ASSERT_EQ(block.arrays[static_cast<std::size_t>(v)].values[n], number(b, v, at));
      }
    }
    ASSERT_EQ(block.hidden.empty(), !form.iblank);
    if (form.iblank) {
      EXPECT_EQ(block.hidden[5], 1);
      EXPECT_EQ(block.hidden[6], 0);  // a fringe point holds flow
    }
  }
}

TEST(Plot3d, EveryLayoutIsToldFromItsBytes) {
  const Folder folder;
  for (const Form& form : all_forms()) {
    SCOPED_TRACE(form.text());
    const auto xyz = folder.write("a.xyz", file(form, false));
    const auto q = folder.write("a.q", file(form, true));
    GridOptions options;
    options.solution = q;
    const auto grid = read_grid(xyz, options);
    expect_numbers(grid, form);
    ASSERT_EQ(grid.blocks[0].arrays.size(), 5U);
    EXPECT_EQ(grid.attributes.at("plot3d.re"), "2.5");
  }
}

TEST(Plot3d, OverflowSolutionsAreRead) {
  const Folder folder;
  for (const bool records : {false, true}) {
    for (const int bits : {32, 64}) {
      const Form form{false, false, records, true, false, bits};
      GridOptions options;
      options.solution = folder.write("a.q", file(form, true, true));
      expect_numbers(read_grid(folder.write("a.xyz", file(form, false)), options), form);
    }
  }
}

TEST(Plot3d, PaddingAfterTheLastNumberIsLetBe) {
  const Folder folder;
  const Form form{false, true, false, false, false, 32};
  GridOptions options;
  options.solution = folder.write("a.q", file(form, true) + std::string(44, '\0'));  // less than 24 floats
  expect_numbers(read_grid(folder.write("a.xyz", file(form, false)), options), form);
  options.solution = folder.write("b.q", file(form, true) + std::string(43, '\0') + "x");
  EXPECT_THROW((void)read_grid(folder / "a.xyz", options), Error);  // not padding: something else
}

TEST(Plot3d, TextMayHaveRepeatCounts) {
  const Folder folder;
  const auto grid =
      read_grid(folder.write("a.xyz", "2,2,2\n 0 1 0 1, 0,1,0,1\n 2*0 2*1 2*0.0 2*1D0\n4*0 4*1.0d+00\n"));
  EXPECT_EQ(grid.blocks[0].points[6], Vec3(0, 1, 1));
}

TEST(Plot3d, AWordOfTheLayoutIsHeld) {
  const Folder folder;
  const auto xyz = folder.write("a.xyz", file({false, true, true, true, false, 64}, false));
  GridOptions options;
  options.plot3d = Plot3dLayout::parse("big,records,f64,multi,plain");
  EXPECT_NO_THROW((void)read_grid(xyz, options));
  for (const char* other : {"little", "stream", "f32", "single", "iblank", "ascii"}) {
    options.plot3d = Plot3dLayout::parse(other);
    EXPECT_THROW((void)read_grid(xyz, options), Error) << other;
  }
  EXPECT_THROW((void)Plot3dLayout::parse("huge"), Error);
  EXPECT_THROW((void)Plot3dLayout::parse(""), Error);
}

std::string refusal(const std::filesystem::path& path, const GridOptions& options = {}) {
  try {
    (void)read_grid(path, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "read";
}

TEST(Plot3d, WhatDoesNotFitIsRefusedWithAReason) {
  const Folder folder;
  const Form form{false, false, true, true, false, 64};
  const std::string good = file(form, false);
  EXPECT_THAT(refusal(folder.write("cut.xyz", good.substr(0, good.size() - 9))),
              HasSubstr("no PLOT3D layout fits"));
  EXPECT_THAT(refusal(folder.write("empty.xyz", "")), HasSubstr("is empty"));
  EXPECT_THAT(refusal(folder.write("text.xyz", "no grid\n")), HasSubstr("number"));
  EXPECT_THAT(refusal(folder.write("bomb.xyz", "9 9 9 1000000000000*0\n")), HasSubstr("repeat count"));
  EXPECT_THAT(refusal(folder.write("meta.p3d", "{\"language\": \"C\"}")), HasSubstr("meta file"));
  EXPECT_THAT(refusal(folder.write("flat.xyz", "1 2 2\n0 1 0 1 0 0 1 1 0 0 1 1\n")), HasSubstr("2-D"));
  EXPECT_THAT(refusal(folder.write("2d.xyz", "3 2\n0 1 2 0 1 2  0 0 0 1 1 1\n")), HasSubstr("2-D"));
  // Sizes that promise more than any memory: nothing is taken on their word.
  EXPECT_THAT(
      refusal(folder.write("huge.xyz", packed<std::int32_t>({2000000000, 2000000000, 2000000000, 0}))),
      HasSubstr("no PLOT3D layout fits"));
  GridOptions other;
  other.solution = folder.write("other.q", file({false, false, true, false, false, 64}, true));
  EXPECT_THAT(refusal(folder.write("good.xyz", good), other), HasSubstr("but the grid has 2 blocks"));
}

/// The public files, where they are.
std::filesystem::path data() {
  const char* folder = std::getenv("PRECIS_DATA");
  return folder == nullptr ? std::filesystem::path() : std::filesystem::path(folder);
}

TEST(Plot3d, PublicGridsAreReadOrRefusedForAReason) {
  if (data().empty()) GTEST_SKIP() << "PRECIS_DATA is not set";
  const auto multi = data() / "plot3d-multi";
  const auto read = [](const std::filesystem::path& xyz, const std::filesystem::path& q) {
    GridOptions options;
    options.solution = q;
    return read_grid(xyz, options);
  };
  const auto fin = read(data() / "bluntfin/bluntfinxyz.bin", data() / "bluntfin/bluntfinq.bin");
  EXPECT_EQ(fin.blocks[0].dims, (Dims{40, 32, 32}));
  EXPECT_FLOAT_EQ(static_cast<float>(fin.blocks[0].arrays[0].values[0]), 2.171F);
  EXPECT_FLOAT_EQ(static_cast<float>(fin.blocks[0].arrays[0].values.back()), 1.4696F);
  EXPECT_EQ(read(data() / "combustor/combxyz.bin", data() / "combustor/combq.bin").blocks[0].dims,
            (Dims{57, 33, 25}));
  const auto records = read(multi / "multi-bin.xyz", multi / "multi-bin.q");
  ASSERT_EQ(records.blocks.size(), 2U);
  for (const auto& [xyz, q] : {std::pair{"multi-bin-C.xyz", "multi-bin-C.q"},
                               {"multi-bin.xyz", "multi-bin-oflow.q"},
                               {"multi-ascii.xyz", "multi-ascii.q"}}) {
    const auto same = read(multi / xyz, multi / q);
    ASSERT_EQ(same.blocks.size(), 2U) << xyz;
    // The text has seven digits.
    for (std::size_t b = 0; b < 2; ++b) {
      for (std::size_t n = 0; n < same.blocks[b].points.size(); ++n) {
        EXPECT_LT((same.blocks[b].points[n] - records.blocks[b].points[n]).norm(), 1e-5);
      }
      EXPECT_NEAR(same.blocks[b].arrays[0].values[17], records.blocks[b].arrays[0].values[17], 1e-5) << q;
    }
  }
  EXPECT_EQ(read(multi / "mbwavelet_ascii.xyz", multi / "mbwavelet_ascii.q").blocks.size(), 3U);
  EXPECT_THAT(refusal(multi / "multi-bin-2D.xyz"), HasSubstr("2-D"));
  GridOptions flat;
  flat.solution = multi / "multi-bin-2D.q";
  EXPECT_THAT(refusal(multi / "multi-bin.xyz", flat), HasSubstr("multi-bin-2D.q"));
  EXPECT_THAT(refusal(multi / "multi.p3d"), HasSubstr("meta file"));
  EXPECT_THAT(refusal(multi / "test.p3d"), HasSubstr("meta file"));
}

}  // namespace
}  // namespace vol::io
