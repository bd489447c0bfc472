// Counts what goes through operator new, so that the frame loop's promise not to allocate can be checked.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "pipeline/parallel/worker_pool.h"

namespace cupola {

// Calls of operator new since the program began. What C libraries take from malloc themselves (SDL, libjpeg,
// drivers) is not in it.
struct HeapAllocations {
  std::int64_t frame_loop = 0;  // by threads that are part of the frame loop
  std::int64_t elsewhere = 0;   // by all other threads, and by those before they became part of it
};
HeapAllocations heap_allocations();

// From now on the calling thread and the pool's are part of the frame loop.
void join_frame_loop(WorkerPool& pool);
void leave_frame_loop();  // the calling thread alone

}  // namespace cupola
