#include <gtest/gtest.h>

#include "base/error.h"
#include "cli/options.h"

namespace vol::cli {
namespace {

TEST(ParseDims, XyzOrderOrCube) {
  EXPECT_EQ(parse_dims("--dims", "3x4x5"), (Dims{3, 4, 5}));
  EXPECT_EQ(parse_dims("--dims", "7"), (Dims{7, 7, 7}));
  for (const char* bad :
       {"", "3x4", "3x4x0", "3x4x-5", "axbxc", "3x4x5x6", "3.5", "99999999x99999999x99999999"}) {
    EXPECT_THROW((void)parse_dims("--dims", bad), Error) << bad;
  }
}

TEST(ParseVec3, NumbersOfOneSign) {
  EXPECT_EQ(parse_vec3("--origin", "+1,-2,3e1"), Vec3(1, -2, 30));
  for (const char* bad : {"+-5", "1,+-2,3", "-+5", "--5", "++5", "+", "1,2", "1,,2"}) {
    EXPECT_THROW((void)parse_vec3("--origin", bad), Error) << bad;
  }
}

TEST(ParseNumbers, FiniteOnesFromAllTexts) {
  EXPECT_EQ(parse_numbers("--isovalue", {"1,-2.5", "+3e1"}), (std::vector<double>{1, -2.5, 30}));
  EXPECT_TRUE(parse_numbers("--isovalue", {}).empty());
  for (const char* bad : {"", "1,,2", "1,", "nan", "inf", "1e999", "1 2", "+-1"}) {
    EXPECT_THROW((void)parse_numbers("--isovalue", {"1", bad}), Error) << bad;
  }
}

TEST(ParseLabels, WholeNumbersUpTo255) {
  EXPECT_EQ(parse_labels("--label", "3"), std::vector<int>{3});
  EXPECT_EQ(parse_labels("--label", "255,0,7"), (std::vector<int>{255, 0, 7}));
  for (const char* bad : {"", "1,", ",1", "256", "-1", "1.5", "x", "1 2"}) {
    EXPECT_THROW((void)parse_labels("--label", bad), Error) << bad;
  }
}

TEST(ParseColour, NumbersFromZeroToOne) {
  EXPECT_EQ(parse_colour("--colour", "0,0.5,1"), Vec3(0, 0.5, 1));
  EXPECT_EQ(parse_colour("--colour", "0.25"), Vec3(0.25, 0.25, 0.25));
  for (const char* bad : {"-0.1", "1.1", "0,0,2", "0,0", "red", "nan"}) {
    EXPECT_THROW((void)parse_colour("--colour", bad), Error) << bad;
  }
}

TEST(ParseStep, WorldLengthOrVoxels) {
  EXPECT_EQ(parse_step("--step", "0.5", 3), 0.5);
  EXPECT_EQ(parse_step("--step", "0.5v", 3), 1.5);
  for (const char* bad : {"0", "-1", "v", "nan", "inf", "1w", "1e999"}) {
    EXPECT_THROW((void)parse_step("--step", bad, 1), Error) << bad;
  }
}

TEST(ParseView, TwoAnglesWithElevationInRange) {
  EXPECT_EQ(parse_view("--view", "30,-20.5"), (std::array<double, 2>{30, -20.5}));
  for (const char* bad : {"30", "+-30,0", "30,91", "30,20,10", "a,b", "inf,0"}) {
    EXPECT_THROW((void)parse_view("--view", bad), Error) << bad;
  }
}

TEST(ParseRegion, HalfOpenBoxOfVoxels) {
  const auto region = parse_region("--region", "0,-1,2:3,4,5");
  EXPECT_EQ(region.lower[1], -1);
  EXPECT_EQ(region.upper[2], 5);
  EXPECT_THROW((void)parse_region("--region", "0,0,0:3,0,3"), Error);
  EXPECT_THROW((void)parse_region("--region", "0,0,0"), Error);
}

TEST(Checks, TakeNumbersOfTheirRangeAlone) {
  for (const char* good : {"1", "+2.5", "1e-300"}) EXPECT_EQ(check_positive(good), "") << good;
  for (const char* bad : {"0", "-1", "nan", "inf", "1e999", "", "1x"})
    EXPECT_NE(check_positive(bad), "") << bad;
  for (const char* good : {"0", "inf", "3"}) EXPECT_EQ(check_non_negative(good), "") << good;
  for (const char* bad : {"-1e-9", "nan", "-inf", ""}) EXPECT_NE(check_non_negative(bad), "") << bad;
  for (const char* good : {"0", "-4e5"}) EXPECT_EQ(check_finite(good), "") << good;
  for (const char* bad : {"inf", "nan", "1e999", "+-4"}) EXPECT_NE(check_finite(bad), "") << bad;
  for (const char* good : {"0", "9223372036854775807"}) EXPECT_EQ(check_whole_number(good), "") << good;
  for (const char* bad : {"-1", "1.5", "9223372036854775808", ""})
    EXPECT_NE(check_whole_number(bad), "") << bad;
}

TEST(Errors, NameTheOptionAndWhatIsExpected) {
  try {
    (void)parse_image_size("--size", "512by512");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find("--size 512by512: expected WIDTHxHEIGHT"), 0u) << e.what();
  }
}

}  // namespace
}  // namespace vol::cli
