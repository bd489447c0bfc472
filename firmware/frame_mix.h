// Two frames into one: what a fade shows.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "pipeline/frame/image.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

// Weights run from 0 to this.
inline constexpr std::int32_t kWholeWeight = 1 << 15;

// Sample by sample, in the values as they are encoded: a + (b - a) * weight / kWholeWeight, rounded to
// nearest, halves up. `a`, `b` and `into` have one size and format; `into` may be `a` or `b`. `weight` is
// that of `b`.
void mix(const Image& a, const Image& b, std::int32_t weight, const MutableImage& into,
         WorkerPool& pool) noexcept;

// mix() of black and `b`, both kXrgb8888; `into` is only written.
void dim(const Image& b, std::int32_t weight, const MutableImage& into, WorkerPool& pool) noexcept;

// Black, in any format.
void blacken(const MutableImage& image) noexcept;

}  // namespace cupola
