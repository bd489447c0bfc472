// Counts calls of operator new in a test program, for code that promises to make none.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace cupola {

// Of the calling thread, since it began.
std::uint64_t heap_allocations();

}  // namespace cupola
