// The program's own operator new: malloc and a counter. The array forms end here too.
// SPDX-License-Identifier: MIT
#include "tests/hal/heap_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::uint64_t> allocations{0};
thread_local bool counted = true;
}  // namespace

namespace cupola {
std::uint64_t heap_allocations() {
  return allocations.load(std::memory_order_relaxed);
}
UncountedHeap::UncountedHeap() {
  counted = false;
}
UncountedHeap::~UncountedHeap() {
  counted = true;
}
}  // namespace cupola

void* operator new(std::size_t size) {
  if (counted) allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
