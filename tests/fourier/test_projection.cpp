#include <gtest/gtest.h>
TEST(Projection, Placeholder) {}
