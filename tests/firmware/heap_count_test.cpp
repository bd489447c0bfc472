// Counting operator new: by whom, and all of them.
// SPDX-License-Identifier: MIT
#include "firmware/heap_count.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <thread>

namespace cupola {
namespace {

// Kept from being optimised away.
void allocate(int count) {
  static std::array<std::unique_ptr<int>, 64> kept;
  for (int i = 0; i < count; ++i) kept[static_cast<std::size_t>(i) % kept.size()] = std::make_unique<int>(i);
}

TEST(HeapCount, CountsEveryAllocationOfAThreadOfTheFrameLoop) {
  WorkerPool pool(1);
  join_frame_loop(pool);
  const std::int64_t before = heap_allocations().frame_loop;
  allocate(100);
  const std::int64_t after = heap_allocations().frame_loop;
  leave_frame_loop();
  EXPECT_EQ(after - before, 100);
}

TEST(HeapCount, CountsAllThreadsOfThePool) {
  WorkerPool pool(4);
  join_frame_loop(pool);
  const std::int64_t before = heap_allocations().frame_loop;
  // Straight calls: compilers may leave out a new-expression whose memory nobody uses.
  pool.run(32, [](int) { ::operator delete(::operator new(8)); });
  const std::int64_t after = heap_allocations().frame_loop;
  leave_frame_loop();
  EXPECT_EQ(after - before, 32);
}

TEST(HeapCount, CountsOtherThreadsApart) {
  WorkerPool pool(1);
  join_frame_loop(pool);
  const HeapAllocations before = heap_allocations();
  std::thread other([] { allocate(50); });
  other.join();
  const HeapAllocations after = heap_allocations();
  leave_frame_loop();
  EXPECT_GE(after.elsewhere - before.elsewhere, 50);
  EXPECT_LE(after.frame_loop - before.frame_loop, 2) << "the thread's own state";
}

TEST(HeapCount, CountsAlignedAllocationsToo) {
  WorkerPool pool(1);
  join_frame_loop(pool);
  const std::int64_t before = heap_allocations().frame_loop;
  void* line = ::operator new (64, std::align_val_t{64});
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(line) % 64, 0U);
  ::operator delete (line, std::align_val_t{64});
  const std::int64_t after = heap_allocations().frame_loop;
  leave_frame_loop();
  EXPECT_EQ(after - before, 1);
}

}  // namespace
}  // namespace cupola
