#include "base/error.h"

#include <gtest/gtest.h>

namespace vol {
namespace {

TEST(Error, NamesAFileOnce) {
  const Error inner("a.nrrd", std::runtime_error("no sizes"));
  EXPECT_STREQ(Error("a.nrrd", inner).what(), "a.nrrd: no sizes");
  EXPECT_STREQ(Error("b.yaml", inner).what(), "b.yaml: a.nrrd: no sizes");
}

TEST(Error, IsOneLineWhateverTheCauseQuotes) {
  const Error error("a.yaml", std::runtime_error("unknown escape: \n\r\t\x7f, \xc3\xa9"));
  EXPECT_STREQ(error.what(), "a.yaml: unknown escape:     , \xc3\xa9");
}

}  // namespace
}  // namespace vol
