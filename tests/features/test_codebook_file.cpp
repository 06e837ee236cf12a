#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "base/rng.h"
#include "io/codebook.h"
#include "textures.h"

namespace vol::features {
namespace {

class CodebookFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "codebook-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::filesystem::path path() const { return folder_ / "book.yaml"; }

  std::filesystem::path folder_;
};

Codebook book_of(const FeatureField& field) {
  Codebook book = train(field, {}).codebook;
  book.wavelet = "haar";
  book.levels = 2;
  return book;
}

TEST_F(CodebookFile, ComesBackWithAllDigits) {
  const FeatureField field(transformed(texture({32, 32, 32}), "haar", 2), {.window = 2.1});
  Codebook book = book_of(field);
  book.features.window = 2.1;
  io::write_codebook(path(), book, {});
  const Codebook back = io::read_codebook(path());
  EXPECT_EQ(back.wavelet, "haar");
  EXPECT_EQ(back.levels, 2);
  EXPECT_EQ(back.features.window, 2.1);
  EXPECT_TRUE(back.features.approximation);
  EXPECT_EQ(back.names, book.names);
  EXPECT_EQ(back.labels, book.labels);
  EXPECT_TRUE(back.mean == book.mean);
  EXPECT_TRUE(back.projection == book.projection);
  EXPECT_TRUE(back.units == book.units);
  EXPECT_EQ(voxels_of(label_volume(field, back)), voxels_of(label_volume(field, book)));
}

TEST_F(CodebookFile, OfAConstantVolume) {
  volume::Volume flat = texture({8, 8, 8});
  for (auto& v : std::get<volume::Grid<float>>(flat.grid).voxels) v = 3;
  const FeatureField field(transformed(flat, "haar", 2), {});
  io::write_codebook(path(), book_of(field), {});
  const auto labels = label_volume(field, io::read_codebook(path()));
  for (const auto l : voxels_of(labels)) EXPECT_EQ(l, 0);
}

// As large as a map can make it.
TEST_F(CodebookFile, OfTheLargestMapIsReadAgain) {
  Codebook book;
  book.wavelet = "haar";
  book.levels = 3;
  Rng rng(3);
  constexpr Eigen::Index kFeatures = 22;
  for (Eigen::Index f = 0; f < kFeatures; ++f) book.names.push_back("feature" + std::to_string(f));
  book.mean = Eigen::VectorXd::Zero(kFeatures);
  book.projection = Eigen::MatrixXd::Identity(kFeatures, kFeatures);
  book.units.resize(kMostUnits, kFeatures);
  for (Eigen::Index i = 0; i < book.units.size(); ++i) book.units.data()[i] = rng.uniform(-1, 1);
  book.labels.assign(kMostUnits, 1);
  io::write_codebook(path(), book, {});
  EXPECT_GT(std::filesystem::file_size(path()), 1U << 20);  // more than other YAML files may have
  const Codebook back = io::read_codebook(path());
  EXPECT_TRUE(back.units == book.units);
}

TEST_F(CodebookFile, FeaturesBeyondFloatsAreRefused) {
  volume::Volume large = texture({8, 8, 8});
  volume::Volume wide = volume::allocate(volume::VoxelType::f64, large.geometry());
  auto& voxels = std::get<volume::Grid<double>>(wide.grid).voxels;
  for (std::size_t n = 0; n < voxels.size(); ++n)
    voxels[n] = 1e300 * double{std::get<volume::Grid<float>>(large.grid).voxels[n]};
  const FeatureField field(
      wavelet::analyze<double>(wide, {.wavelet = "haar", .levels = 1}, volume::value_range(wide)), {});
  EXPECT_THROW(io::write_features(folder_ / "features.nrrd", field, {}), Error);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "features.nrrd"));
}

TEST_F(CodebookFile, HostileTextIsRefusedInOneLine) {
  const FeatureField field(transformed(texture({16, 16, 16}), "haar", 2), {});
  io::write_codebook(path(), book_of(field), {});
  std::stringstream whole;
  whole << std::ifstream(path()).rdbuf();
  const std::string good = whole.str();
  const auto refused = [&](const std::string& text) {
    std::ofstream(path()) << text;
    try {
      (void)io::read_codebook(path());
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    auto text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return refused(text.replace(at, from.size(), to));
  };
  using testing::AllOf;
  using testing::HasSubstr;
  using testing::Not;
  const auto one_line = AllOf(HasSubstr("book.yaml"), Not(HasSubstr("\n")));
  EXPECT_THAT(refused(""), one_line);
  EXPECT_THAT(refused("[1, 2"), one_line);
  EXPECT_THAT(refused("just words"), one_line);
  EXPECT_THAT(with("wavelet:", "wavlet:"), AllOf(one_line, HasSubstr("wavlet")));
  EXPECT_THAT(with("wavelet:", "\"wave\\nlet\":"), one_line);  // a line end in the key
  EXPECT_THAT(with("wavelet: haar", "wavelet: \"ha\\nar\""),
              AllOf(one_line, HasSubstr("a word is expected")));
  EXPECT_THAT(with("level1.LLH", "\"level1\\nLLH\""), AllOf(one_line, HasSubstr("a word is expected")));
  EXPECT_THAT(with("levels: 2", "levels: two"), AllOf(one_line, HasSubstr("line")));
  EXPECT_THAT(with("mean: [", "mean: [.nan, "), one_line);
  EXPECT_THAT(with("mean: [", "mean: [1, "), one_line);
  EXPECT_THAT(with("labels: [", "labels: [0, "), AllOf(one_line, HasSubstr("24")));
  EXPECT_THAT(with("labels: [", "labels: {a: "), one_line);
  EXPECT_THAT(with("features: [", "features: [["), one_line);
  // Cut off anywhere: an error, or (within the last digits and brackets) nothing worse.
  for (std::size_t n = 0; n + 40 < good.size(); n += 97)
    EXPECT_NE(refused(good.substr(0, n)), "accepted") << n;
}

}  // namespace
}  // namespace vol::features
