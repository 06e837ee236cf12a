#include "io/label_looks.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace vol::io {
namespace {

using ::testing::HasSubstr;

std::filesystem::path written(const std::string& text) {
  const auto path = std::filesystem::path(::testing::TempDir()) /
                    (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml");
  std::ofstream(path) << text;
  return path;
}

std::string refusal(const std::string& text) {
  try {
    (void)read_label_looks(written(text));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(LabelLooks, ArriveInTheirPlaces) {
  const auto looks = read_label_looks(written("labels: [[3, 0.5, 0.25, 2, 0.1], [0, 0, 0, 0, 1]]"));
  ASSERT_EQ(looks.size(), 4U);
  EXPECT_EQ(looks[3].colour, Vec3(0.5, 0.25, 2));
  EXPECT_EQ(looks[3].opacity, 0.1);
  EXPECT_EQ(looks[0].opacity, 1);
  EXPECT_EQ(looks[1].opacity, 0);  // not listed
  EXPECT_EQ(to_json(looks).dump(), "[[0,0.0,0.0,0.0,1.0],[3,0.5,0.25,2.0,0.1]]");
  // IEC 61966-2-1: 0.5 is ((0.5 + 0.055) / 1.055)^2.4 of the light.
  EXPECT_NEAR(read_label_looks(written("space: srgb\nlabels: [[0, 0.5, 0, 1, 1]]"))[0].colour[0], 0.21404114,
              1e-8);
}

TEST(LabelLooks, TheFileShippedIsTheDefaultButForLabelZero) {
  const auto shipped = read_label_looks(std::filesystem::path(PRECIS_CONFIGS) / "transfer/labels.yaml");
  const auto own = default_label_looks();
  ASSERT_EQ(shipped.size(), 8U);
  EXPECT_EQ(own.size(), 256U);
  EXPECT_EQ(own[0].opacity, 0);
  for (std::size_t l = 1; l < 8; ++l) {
    EXPECT_EQ(shipped[l].colour, own[l].colour) << l;
    EXPECT_EQ(shipped[l].opacity, own[l].opacity) << l;
  }
}

TEST(LabelLooks, RefusalsNameTheLine) {
  EXPECT_THAT(refusal("labels:\n- [1, 1, 1, 1, 0.5]\n- [1, 0, 0, 0, 0.5]"),
              HasSubstr("line 3: labels: label 1"));
  EXPECT_THAT(refusal("labels: [[1.5, 0, 0, 0, 0.5]]"), HasSubstr("whole number"));
  EXPECT_THAT(refusal("labels: [[256, 0, 0, 0, 0.5]]"), HasSubstr("whole number"));
  EXPECT_THAT(refusal("labels: [[1, 0, 0, 0, 1.5]]"), HasSubstr("opacity"));
  EXPECT_THAT(refusal("labels: [[1, -1, 0, 0, 0.5]]"), HasSubstr("colours"));
  EXPECT_THAT(refusal("labels: [[1, 0, 0, 0.5]]"), HasSubstr("5 numbers"));
  EXPECT_THAT(refusal("labels: 7"), HasSubstr("a list"));
  EXPECT_THAT(refusal("space: cmyk\nlabels: []"), HasSubstr("cmyk"));
  EXPECT_THAT(refusal("lables: []"), HasSubstr("unknown key"));
}

}  // namespace
}  // namespace vol::io
