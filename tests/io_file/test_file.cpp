#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "io/file.h"

namespace vol::io {
namespace {

namespace fs = std::filesystem;

class FileTest : public ::testing::Test {
 protected:
  fs::path folder = fs::temp_directory_path() / ("precis-file-test-" + std::to_string(::getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }
  static std::string content(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
  }
};

TEST_F(FileTest, OutputAppearsOnlyWhenCommitted) {
  const auto path = folder / "a.bin";
  std::ofstream(path) << "old";
  {
    OutputFile out(path);
    out.write(std::string_view("half"));
  }
  EXPECT_EQ(content(path), "old");
  EXPECT_EQ(entries(), 1u);
  OutputFile out(path);
  const std::string large(300000, 'x');
  out.write(std::string_view("new"));
  out.write(std::string_view(large));
  EXPECT_EQ(content(path), "old");
  out.commit();
  EXPECT_EQ(content(path), "new" + large);
  EXPECT_EQ(entries(), 1u);
}

TEST_F(FileTest, ALinkStaysALinkAndTheFileBehindItIsReplaced) {
  fs::create_directory(folder / "far");
  std::ofstream(folder / "far" / "a.bin") << "old";
  fs::create_symlink(fs::path("far") / "a.bin", folder / "link.bin");
  OutputFile out(folder / "link.bin");
  out.write(std::string_view("new"));
  out.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link.bin"));
  EXPECT_EQ(content(folder / "far" / "a.bin"), "new");
}

TEST_F(FileTest, ALinkToNothingYetStaysALinkAndItsTargetIsMade) {
  fs::create_directory(folder / "far");
  fs::create_symlink("second.bin", folder / "first.bin");
  fs::create_symlink(fs::path("far") / "a.bin", folder / "second.bin");
  EXPECT_NO_THROW(require_writable(folder / "first.bin"));
  OutputFile out(folder / "first.bin");
  out.write(std::string_view("new"));
  out.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "first.bin"));
  EXPECT_TRUE(fs::is_symlink(folder / "second.bin"));
  EXPECT_EQ(content(folder / "far" / "a.bin"), "new");
}

TEST_F(FileTest, TheLongestNamesTheFileSystemTakesAreWritten) {
  for (const std::string& name : {std::string(251, 'n') + ".bin", "n." + std::string(253, 'x'),
                                  std::string(200, 'n') + "." + std::string(54, 'x')}) {
    const auto path = folder / name;
    OutputFile out(path);
    out.write(std::string_view("x"));
    out.commit();
    EXPECT_EQ(content(path), "x");
  }
}

TEST_F(FileTest, ATemporaryNameKeepsTheExtensionThatLibrariesChooseBy) {
  EXPECT_EQ(OutputFile(folder / (std::string(251, 'n') + ".vdb")).temporary_path().extension(), ".vdb");
}

TEST_F(FileTest, NothingIsWrittenThroughALinkThatLiesInWait) {
  const auto victim = folder / "victim", path = folder / "a.bin";
  std::ofstream(victim) << "untouched";
  std::optional<OutputFile> out(path);  // in the same place twice, so that the temporary name is the same
  const auto temporary = out->temporary_path();
  out.reset();
  fs::create_symlink(victim, temporary);
  out.emplace(path);
  ASSERT_EQ(out->temporary_path(), temporary);
  out->write(std::string_view("mine"));
  out->commit();
  EXPECT_EQ(content(path), "mine");
  EXPECT_EQ(content(victim), "untouched");
}

TEST_F(FileTest, AWriteProtectedFileIsNotReplaced) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everything";
  const auto path = folder / "kept.bin";
  std::ofstream(path) << "old";
  fs::permissions(path, fs::perms::owner_read);
  EXPECT_THROW(OutputFile{path}, Error);
  EXPECT_EQ(content(path), "old");
}

TEST_F(FileTest, AClosedFolderIsToldBeforehand) {
  if (::geteuid() == 0) GTEST_SKIP() << "no folder is closed to root";
  fs::create_directory(folder / "closed");
  fs::permissions(folder / "closed", fs::perms::none);
  EXPECT_THROW(require_writable(folder / "closed" / "a.bin"), Error);
  EXPECT_THROW(OutputFile{folder / "closed" / "a.bin"}, Error);
  fs::permissions(folder / "closed", fs::perms::owner_all);
}

TEST_F(FileTest, WhatCannotBeWrittenIsToldBeforehand) {
  std::ofstream(folder / "a.bin") << "old";
  for (const fs::path& good :
       {folder / "a.bin", folder / "new.bin", fs::path("new.bin"), fs::path("-"), fs::path("/dev/full")}) {
    EXPECT_NO_THROW(require_writable(good)) << good;
  }
  fs::create_symlink("circle.bin", folder / "circle.bin");
  fs::create_symlink(fs::path("none") / "a.bin", folder / "astray.bin");
  for (const fs::path& bad : {folder, folder / "none" / "a.bin", folder / "a.bin" / "b.bin",
                              folder / "circle.bin", folder / "circle.bin" / "a.bin", folder / "astray.bin",
                              folder / std::string(256, 'n'), folder / "new" / ""}) {
    for (const bool beforehand : {true, false}) {
      try {
        if (beforehand) {
          require_writable(bad);
        } else {
          OutputFile out(bad);
        }
        ADD_FAILURE() << bad << " was taken";
      } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).find(bad.string() + ": "), 0u) << e.what();
      }
    }
  }
  EXPECT_EQ(content(folder / "a.bin"), "old");
  EXPECT_EQ(entries(), 3u);
}

TEST_F(FileTest, InterruptionRemovesWhatIsHalfWritten) {
  OutputFile out(folder / "b.bin");
  out.write(std::string_view("half"));
  remove_uncommitted_outputs();
  EXPECT_EQ(entries(), 0u);
}

TEST_F(FileTest, FullDiskIsAnErrorNotASuccess) {
  OutputFile out("/dev/full");
  EXPECT_THROW(
      {
        out.write(std::string_view(std::string(1 << 17, 'x')));
        out.commit();
      },
      Error);
}

TEST_F(FileTest, UnwritablePlaceNamesTheFile) {
  try {
    OutputFile out(folder / "missing" / "c.bin");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("c.bin: cannot write"), std::string::npos) << e.what();
  }
}

TEST_F(FileTest, ReadsLinesThenBytesThenSaysWhatIsMissing) {
  const auto path = folder / "d.txt";
  std::ofstream(path) << "one\r\ntwo\n" << std::string(100000, 'z');
  InputFile in(path);
  EXPECT_EQ(in.peek(3), "one");
  EXPECT_EQ(in.read_line(), "one");
  EXPECT_EQ(in.read_line(), "two");
  EXPECT_EQ(in.position(), 9);
  EXPECT_NO_THROW(in.require(100000));
  EXPECT_THROW(in.require(100001), Error);
  std::vector<char> bytes(100001);
  try {
    in.read_exactly(bytes.data(), bytes.size());
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("data ends after 100000 of 100001 bytes"), std::string::npos)
        << e.what();
  }
  EXPECT_TRUE(in.at_end());
  EXPECT_THROW((void)in.read_line(), Error);
}

TEST_F(FileTest, RestIsLimited) {
  const auto path = folder / "e.bin";
  std::ofstream(path) << std::string(5000, 'q');
  EXPECT_EQ(InputFile(path).read_rest(5000).size(), 5000u);
  EXPECT_THROW((void)InputFile(path).read_rest(4999), Error);
}

TEST_F(FileTest, FoldersAndMissingFilesAreRefused) {
  EXPECT_THROW(InputFile in(folder), Error);
  EXPECT_THROW(InputFile in(folder / "nothing"), Error);
}

}  // namespace
}  // namespace vol::io
