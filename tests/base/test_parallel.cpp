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

TEST(LoopProgress, CountsTheChunksOfTheOutermostLoopAlone) {
  EXPECT_EQ(loop_progress().total, 0);
  std::atomic<std::int64_t> most{0}, wrong{0};
  parallel_for(0, 100, 10, [&](std::int64_t, std::int64_t) {
    parallel_for(0, 7, 1, [](std::int64_t, std::int64_t) {});
    const LoopProgress p = loop_progress();
    wrong += p.total != 10 || p.done < 0 || p.done > 9;  // this chunk is not done yet
    most = std::max(most.load(), p.done);
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(most, 0);
  EXPECT_EQ(loop_progress().total, 0);
}

TEST(LoopProgress, IsNoneAfterAnException) {
  EXPECT_THROW(parallel_for(0, 9, 1, [](std::int64_t, std::int64_t) { throw std::runtime_error("x"); }),
               std::runtime_error);
  EXPECT_EQ(loop_progress().total, 0);
  EXPECT_EQ(loop_progress().done, 0);
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
