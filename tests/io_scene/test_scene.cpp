#include "io/scene.h"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace vol::io {
namespace {

using ::testing::HasSubstr;

std::filesystem::path written(const std::string& name, const std::string& text) {
  const auto folder = std::filesystem::path(::testing::TempDir()) /
                      ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << text;
  return folder / name;
}

std::string refusal(const std::string& text) {
  try {
    (void)read_scene(written("scene.yaml", text));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Scene, AllKeysArrive) {
  (void)written("grey.yaml", "colours: [[0, 0, 0, 0], [1, 1, 1, 1]]\nopacity: [[0, 0], [1, 0.5]]\n");
  const auto file = read_scene(written("scene.yaml", R"(
camera: {azimuth: 30, elevation: -20, fov: 40, distance: 7, target: [1, 2, 3], up: [0, 0, 1]}
transfer: grey.yaml
reference_length: 2.5
shading: {ambient: 0.1, diffuse: 0.5, specular: 0.3, exponent: 7, light: [1, 0, 0]}
background: [0.1, 0.2, 0.3]
model: xray
quadrature: preintegrated
step: 0.25v
reconstruction: catmull-rom
)"));
  const auto& s = file.scene;
  EXPECT_EQ(s.view.projection, camera::Projection::perspective);
  EXPECT_EQ(s.view.azimuth, 30);
  EXPECT_EQ(s.view.elevation, -20);
  EXPECT_EQ(s.view.fov, 40);
  EXPECT_EQ(s.view.distance, 7);
  EXPECT_EQ(s.view.target, Vec3(1, 2, 3));
  EXPECT_EQ(s.view.up, Vec3(0, 0, 1));
  EXPECT_TRUE(file.has_transfer);
  EXPECT_EQ(s.transfer.opacity(0.5), 0.25);
  EXPECT_EQ(s.reference_length, 2.5);
  ASSERT_TRUE(s.shading);
  EXPECT_EQ(s.shading->exponent, 7);
  EXPECT_EQ(s.shading->light, Vec3(1, 0, 0));
  EXPECT_EQ(s.background, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(s.model, render::Model::xray);
  EXPECT_EQ(file.quadrature, render::Quadrature::preintegrated);
  EXPECT_EQ(file.step, "0.25v");
  EXPECT_EQ(file.reconstruction, volume::Reconstruction::catmull_rom);
}

TEST(Scene, RefusalsNameFileLineAndKey) {
  EXPECT_THAT(refusal("camera: {azimuth: 1}\nbackgruond: [0, 0, 0]\n"),
              AllOf(HasSubstr("scene.yaml"), HasSubstr("line 2"), HasSubstr("'backgruond'"),
                    HasSubstr("background")));
  EXPECT_THAT(refusal("camera:\n  azimuth: 1\n  azimut: 2\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("'azimut'")));
  EXPECT_THAT(refusal("camera: {azimuth: north}\n"), AllOf(HasSubstr("azimuth"), HasSubstr("number")));
  EXPECT_THAT(refusal("model: composit\n"), AllOf(HasSubstr("line 1"), HasSubstr("composite, xray, mip")));
  EXPECT_THAT(refusal("camera: {width: 3, fov: 30}\n"), HasSubstr("either width"));
  EXPECT_THAT(refusal("reference_length: -1\n"), HasSubstr("positive"));
  EXPECT_THAT(refusal("background: [0, 0]\n"), HasSubstr("3 numbers"));
  EXPECT_THAT(refusal("background: [0, 0, .nan]\n"), HasSubstr("finite"));
  EXPECT_THAT(refusal("transfer: {colours: [[0, 0, 0, 0]], opacity: [[0, 0], [1, 1.5]]}\n"),
              HasSubstr("opacity"));
  EXPECT_THAT(refusal("transfer: {colours: [[0, 0, 0, 0]]}\n"), HasSubstr("without opacity"));
  EXPECT_THAT(refusal("transfer: nowhere.yaml\n"), HasSubstr("nowhere.yaml"));
  EXPECT_THAT(refusal("camera: {azimuth: 1\n"), HasSubstr("scene.yaml"));
  EXPECT_THAT(refusal("- 1\n- 2\n"), HasSubstr("map"));
  EXPECT_THAT(refusal("model: xray\nmodel: mip\n"), HasSubstr("twice"));
  for (const char* text :
       {"\"mo\\ndel\": xray\n", "model: \"xr\\nay\"\n", "transfer: \"no\\nwhere.yaml\"\n"}) {
    EXPECT_THAT(refusal(text), AllOf(HasSubstr("line 1"), ::testing::Not(HasSubstr("\n")))) << text;
  }
  EXPECT_THAT(refusal(std::string(2 << 20, '#')), HasSubstr("scene.yaml"));
}

TEST(Transfer, RangeScalesAndSrgbIsConverted) {
  const auto transfer = read_transfer_function(written("t.yaml", R"(
space: srgb
range: [100, 300]
colours: [[0, 0, 0, 0], [1, 1, 0.5, 0]]
opacity: [[0.5, 0], [1, 1]]
)"));
  EXPECT_EQ(transfer.breakpoints(), (std::vector<double>{100, 200, 300}));
  EXPECT_NEAR(transfer.colour(300)[1], 0.21404114048223255, 1e-15);  // IEC 61966-2-1 of 0.5
  EXPECT_EQ(transfer.opacity(250), 0.5);
}

TEST(Transfer, ParaViewPreset) {
  const auto transfer = read_transfer_function(written("p.json", R"([{"Name": "x", "ColorSpace": "RGB",
    "RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1], "Points": [0, 0, 0.25, 0, 4, 0.8, 0.5, 1, 8, 0.2, 0.5, 0.4, 10, 0.6, 0.5, 0]}])"));
  EXPECT_NEAR(transfer.opacity(1), 0.4, 1e-12);    // midpoint at a quarter: half the rise there
  EXPECT_NEAR(transfer.opacity(5.9), 0.8, 1e-12);  // sharpness 1: a step at the midpoint
  EXPECT_NEAR(transfer.opacity(6.1), 0.2, 1e-12);
  EXPECT_NEAR(transfer.opacity(9), 0.4, 1e-12);  // the curve is symmetric about its midpoint
  EXPECT_LT(transfer.opacity(8.4), 0.22);        // and flat at its ends
  EXPECT_THROW((void)read_transfer_function(written("q.json", "[]")), Error);
  EXPECT_THROW((void)read_transfer_function(written("r.json", "{\"RGBPoints\": [1, 2]}")), Error);
  EXPECT_THROW((void)read_transfer_function(written("s.json", "{\"RGBPoints\": \"x\"}")), Error);
  EXPECT_THROW((void)read_transfer_function(written("t.json", "{")), Error);
}

TEST(Bezier, ComesBackAsItWasWritten) {
  const transfer::BezierTransfer bezier{
      -100,
      3926.5,
      {{"bone: \"hard\"", Vec3(1, 0.9, 0.1 + 0.2), transfer::BezierCurve({0, 1.0 / 3, 2e-17, -1.5})},
       {"", Vec3::Ones(), transfer::BezierCurve({0.25, 1, 0.5}, {0, 0.7, 1})}}};
  const auto path = written("b.yaml", "");
  write_bezier(path, bezier, {{"precis.tool", "tf-fit"}});
  const auto back = read_bezier(path);
  ASSERT_TRUE(back);
  EXPECT_EQ(to_json(*back), to_json(bezier));
  EXPECT_EQ(back->bands[0].curve.ordinates(), bezier.bands[0].curve.ordinates());
  // As a transfer function, and in a scene.
  EXPECT_EQ(read_transfer_function(path).opacity(-100), 0.25);
  const auto scene = read_scene(written("s.yaml", "transfer: b.yaml\n"));
  ASSERT_TRUE(scene.bezier);
  EXPECT_EQ(to_json(*scene.bezier), to_json(bezier));
  EXPECT_EQ(read_bezier(written("short.yaml", "bezier: [0, 2]\n"))->bands[0].curve.ordinates(),
            (std::vector<double>{0, 2}));
  EXPECT_FALSE(read_bezier(written("other.yaml", "colours: [[0, 0, 0, 0]]\nopacity: [[0, 0]]\n")));
}

TEST(Bezier, RefusalsNameFileAndLine) {
  const auto refused = [](const std::string& text) {
    try {
      (void)read_bezier(written("b.yaml", text));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  std::string many = "bezier: [0";
  for (int i = 1; i < 22; ++i) many += ", 0";
  for (const auto& [text, word] : std::vector<std::pair<std::string, std::string>>{
           {"bezier: []\n", "list"},
           {"bezier: 3\n", "list"},
           {many + "]\n", "21"},
           {"bezier: [.nan, 1]\n", "finite"},
           {"bezier: [one]\n", "number"},
           {"bezier: [[0, 1], 2]\n", "abscissae"},
           {"bezier: [[0, 1], [2, 1], [1, 1]]\n", "rise"},
           {"bezier: [0, 1]\nrange: [3, 3]\n", "range"},
           {"bezier: [0, 1]\ncolours: [[0, 0, 0, 0]]\n", "unknown key"},
           {"bezier: [{name: a}]\n", "points"},
           {"bezier: [{points: [1], colour: [0, -1, 0]}]\n", "negative"},
           {"bezier: [{points: [1], colour: [0, 1e31, 0]}]\n", "1e30"},
           {"bezier: [{points: [1], name: \"Z\xe4hne\"}]\n", "UTF-8"},
           {"bezier: [{points: [1], color: [0, 1, 0]}]\n", "unknown key"}}) {
    EXPECT_THAT(refused(text), AllOf(HasSubstr("b.yaml: line "), HasSubstr(word))) << text;
  }
}

TEST(Profile, OfAText) {
  const auto profile = read_profile(written("p.csv", "value,opacity\n# bone\n\n0, 0\n 10 ,1.5\n10,-1\n"));
  EXPECT_EQ(profile.value(5), 0.75);
  EXPECT_EQ(profile.value(10), -1);
  for (const char* text :
       {"", "a,b\n", "0,nan\n", "nan,0\n", "0,inf\n", "0\n", "0,1,2\n", "1,0\n0,0\n", "0,0\nx,y\n"}) {
    EXPECT_THROW((void)read_profile(written("q.csv", text)), Error) << text;
  }
}

TEST(Scene, ShippedScenesAreRead) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PRECIS_CONFIGS "/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    ++scenes;
    const auto file = read_scene(entry.path());
    EXPECT_TRUE(file.has_transfer) << entry.path();
    EXPECT_FALSE(to_json(file.scene).dump().empty());
  }
  EXPECT_GE(scenes, 8);
  const auto opaque = read_scene(PRECIS_CONFIGS "/scenes/he-opaque.yaml").scene;
  EXPECT_EQ(opaque.view.width, 100);
  EXPECT_EQ(opaque.reference_length, 1);
  EXPECT_EQ(opaque.transfer.opacity(10), 0);
  EXPECT_EQ(opaque.transfer.opacity(255), 0.3);
  EXPECT_EQ(opaque.transfer.colour(51), Vec3(0.2, 0.2, 0.2));
}

}  // namespace
}  // namespace vol::io
