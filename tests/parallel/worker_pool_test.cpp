// The worker pool: every task once, whatever the number of threads.
// SPDX-License-Identifier: MIT
#include "pipeline/parallel/worker_pool.h"

#include <numeric>
#include <stdexcept>

#include <gtest/gtest.h>

namespace cupola {
namespace {

class WorkerPoolTest : public testing::TestWithParam<int> {};

TEST_P(WorkerPoolTest, DoesEveryTaskExactlyOnce) {
  WorkerPool pool(GetParam());
  std::vector<std::atomic<int>> calls(10'007);
  pool.run(static_cast<int>(calls.size()), [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
  for (const std::atomic<int>& count : calls) ASSERT_EQ(count, 1);
}

TEST_P(WorkerPoolTest, IsReadyAgainAfterEveryRun) {
  WorkerPool pool(GetParam());
  std::vector<int> values(13);  // plain ints: the run's end must order the workers' writes before our reads
  for (int round = 1; round <= 10'000; ++round) {
    pool.run(13, [&](int i) { values[static_cast<std::size_t>(i)] += i; });
    ASSERT_EQ(std::accumulate(values.begin(), values.end(), 0), 78 * round);
    if (round % 16 == 0) {
      pool.run(13, [&](int i) { values[static_cast<std::size_t>(i)] -= round * i; });
      ASSERT_EQ(std::accumulate(values.begin(), values.end(), 0), 0);
      pool.run(13, [&](int i) { values[static_cast<std::size_t>(i)] += round * i; });
    }
  }
}

TEST_P(WorkerPoolTest, DoesNothingWhenThereIsNothingToDo) {
  WorkerPool pool(GetParam());
  pool.run(0, [](int) { FAIL(); });
}

TEST_P(WorkerPoolTest, ThrowsATasksExceptionAgainAndStaysUsable) {
  WorkerPool pool(GetParam());
  for (int round = 0; round < 100; ++round) {
    EXPECT_THROW(pool.run(100,
                          [](int i) {
                            if (i == 37) throw std::runtime_error("task 37");
                          }),
                 std::runtime_error);
    std::atomic<int> calls = 0;
    pool.run(100, [&](int) { ++calls; });
    ASSERT_EQ(calls, 100);
  }
}

TEST_P(WorkerPoolTest, StopsIdle) {
  for (int i = 0; i < 200; ++i) WorkerPool pool(GetParam());
}

TEST_P(WorkerPoolTest, CountsTheCallingThread) {
  EXPECT_EQ(WorkerPool(GetParam()).threads(), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Threads, WorkerPoolTest, testing::Values(1, 2, 3, 8));

TEST(WorkerPool, TakesOneThreadACoreWhenAskedForNone) {
  EXPECT_GE(WorkerPool(0).threads(), 1);
}

TEST(WorkerPool, WithOneThreadRunsInOrderOnTheCaller) {
  WorkerPool pool(1);
  std::vector<int> order;
  pool.run(5, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace cupola
