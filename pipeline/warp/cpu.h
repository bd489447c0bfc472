// The instruction sets that the warp's kernels are written for.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cupola {

enum class Cpu : std::uint8_t { kScalar, kSse4, kAvx2, kAvx512, kNeon };

inline constexpr std::string_view kCpuNames[] = {"scalar", "sse4", "avx2", "avx512", "neon"};

// Whether this machine has all that the kernels of `cpu` use (kSse4: SSE4.1 and SSSE3;
// kAvx512: F, BW, DQ, VL, VBMI and VNNI).
bool supported(Cpu cpu);
// The fastest of the supported ones.
Cpu best_cpu();
inline std::string_view name(Cpu cpu) {
  return kCpuNames[static_cast<std::size_t>(cpu)];
}

}  // namespace cupola
