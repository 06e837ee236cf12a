#include "io/any_volume.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "base/error.h"

namespace vol::io {
namespace {

namespace fs = std::filesystem;

class AnyVolume : public testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("precis-any-volume-" + std::to_string(::getpid()));
  volume::Volume v = volume::allocate(volume::VoxelType::f16, {.dims = {3, 4, 5}});
  void SetUp() override {
    fs::create_directories(folder);
    volume::visit(v, [](auto& grid) {
      using T = typename std::decay_t<decltype(grid)>::value_type;
      std::fill(grid.voxels.begin(), grid.voxels.end(), static_cast<T>(1.0f));
    });
  }
  void TearDown() override { fs::remove_all(folder); }
  static std::string failure(const std::function<void()>& work) {
    try {
      work();
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
};

TEST_F(AnyVolume, EveryFormatIsWrittenByExtensionInAnyCaseAndByName) {
  for (const std::string format :
       {"nrrd", "nhdr", "mha", "mhd", "vti", "vdb", "raw", "NRRD", "Mha", "VTI", "VDB"}) {
    SCOPED_TRACE(format);
    for (const auto& [path, named] :
         {std::pair{folder / ("v." + format), std::string()}, {folder / "v.dat", format}}) {
      EXPECT_NO_THROW(require_volume_output(path, named));
      EXPECT_NO_THROW((void)write_any_volume(path, v, {.format = named}));
      if (format == "raw") continue;  // it does not say what it holds
      const volume::Volume back = read_any_volume(path);
      EXPECT_EQ(back.geometry().dims, v.geometry().dims);
      EXPECT_EQ(back.voxel_type(), v.voxel_type());
    }
  }
}

TEST_F(AnyVolume, WhatWouldBeRefusedAfterTheWorkIsRefusedBefore) {
  for (const auto& [path, format] : {std::pair{folder / "v.nii", ""},
                                     {folder / "v", ""},
                                     {folder / "v.nrrd", "exr"},
                                     {folder / "v.vdb", "nrr"},
                                     {folder / "v.", ""},
                                     {"-", "nhdr"},
                                     {"-", "MHD"},
                                     {folder, "nrrd"},
                                     {folder / "none" / "v.vdb", ""}}) {
    SCOPED_TRACE(path.string() + " " + format);
    const std::string before = failure([&] { require_volume_output(path, format); });
    EXPECT_NE(before, "");
    EXPECT_EQ(before, failure([&] { (void)write_any_volume(path, v, {.format = format}); }));
  }
}

}  // namespace
}  // namespace vol::io
