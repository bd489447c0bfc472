// Counts calls of operator new in a test program, for code that promises to make none.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace cupola {

// Of all threads, since the program began.
std::uint64_t heap_allocations();

// While it lives, nothing is counted: for what stands in for the kernel. Not to be nested.
class UncountedHeap {
 public:
  UncountedHeap();
  ~UncountedHeap();
  UncountedHeap(const UncountedHeap&) = delete;
  UncountedHeap& operator=(const UncountedHeap&) = delete;
};

}  // namespace cupola
