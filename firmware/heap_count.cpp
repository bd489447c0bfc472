// The program's own operator new and delete: malloc and a counter.
// SPDX-License-Identifier: MIT
#include "firmware/heap_count.h"

#include <atomic>
#include <barrier>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace cupola {
namespace {

std::atomic<std::int64_t> in_frame_loop{0};
std::atomic<std::int64_t> elsewhere{0};
thread_local bool part_of_frame_loop = false;

}  // namespace

// Shared by the operators below; null when there is no memory.
void* count_and_allocate(std::size_t size, std::size_t alignment) noexcept {
  (part_of_frame_loop ? in_frame_loop : elsewhere).fetch_add(1, std::memory_order_relaxed);
  if (size == 0) size = 1;
  if (alignment <= alignof(std::max_align_t)) return std::malloc(size);
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

HeapAllocations heap_allocations() {
  return {in_frame_loop.load(), elsewhere.load()};
}

void join_frame_loop(WorkerPool& pool) {
  // Nobody passes before everybody has come: so each thread takes one task.
  std::barrier everybody(pool.threads());
  pool.run(pool.threads(), [&](int) {
    part_of_frame_loop = true;
    everybody.arrive_and_wait();
  });
}

void leave_frame_loop() {
  part_of_frame_loop = false;
}

}  // namespace cupola

void* operator new(std::size_t size) {
  if (void* memory = cupola::count_and_allocate(size, 1)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return cupola::count_and_allocate(size, 1);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return cupola::count_and_allocate(size, 1);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (void* memory = cupola::count_and_allocate(size, static_cast<std::size_t>(alignment))) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return operator new(size, alignment);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return cupola::count_and_allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return cupola::count_and_allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  std::free(memory);
}
