// The instruction sets that the warp's kernels are written for.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cupola {

enum class Cpu : std::uint8_t { kScalar, kAvx2, kAvx512 };

inline constexpr std::string_view kCpuNames[] = {"scalar", "avx2", "avx512"};

// Whether this machine has all that the kernels of `cpu` use (kAvx512: F, BW, DQ, VL, VBMI and VNNI).
bool supported(Cpu cpu);
// The fastest of the supported ones.
Cpu best_cpu();
inline std::string_view name(Cpu cpu) {
  return kCpuNames[static_cast<std::size_t>(cpu)];
}

}  // namespace cupola
