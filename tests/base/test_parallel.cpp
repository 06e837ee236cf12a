#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "base/parallel.h"
#include "base/rng.h"

namespace vol {
namespace {

TEST(ParallelFor, VisitsEveryItemOnce) {
  std::vector<std::atomic<int>> visits(1013);
  parallel_for(0, 1013, 17, [&](std::int64_t begin, std::int64_t end) {
    for (auto n = begin; n < end; ++n) ++visits[static_cast<std::size_t>(n)];
  });
  for (const auto& v : visits) EXPECT_EQ(v.load(), 1);
}

TEST(ParallelFor, ExceptionsReachTheCaller) {
  EXPECT_THROW(parallel_for(0, 100, 1, [](std::int64_t, std::int64_t) { throw std::runtime_error("x"); }),
               std::runtime_error);
}

// Floating-point sums depend on order; chunk order must not depend on the number of threads.
TEST(ParallelReduce, SumHasTheSameBitsForAnyThreadCount) {
  Rng rng(5);
  std::vector<double> x(100003);
  for (auto& v : x) v = rng.normal() * std::exp(20 * rng.normal());
  const auto sum = [&] {
    return parallel_reduce<double>(
        0, static_cast<std::int64_t>(x.size()), 100,
        [&](std::int64_t begin, std::int64_t end) {
          double s = 0;
          for (auto n = begin; n < end; ++n) s += x[static_cast<std::size_t>(n)];
          return s;
        },
        [](double& total, double part) { total += part; });
  };
  set_thread_count(1);
  const double one = sum();
  set_thread_count(2);
  EXPECT_EQ(sum(), one);
  set_thread_count(0);
  EXPECT_EQ(sum(), one);
}

}  // namespace
}  // namespace vol
