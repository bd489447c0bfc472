// What an x86-64 machine can run.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/row_store_wide.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

bool supported(Cpu cpu) {
  switch (cpu) {
    case Cpu::kScalar:
      return true;
    case Cpu::kSse4:
      return __builtin_cpu_supports("ssse3") && __builtin_cpu_supports("sse4.1");
    case Cpu::kAvx2:
      return __builtin_cpu_supports("avx2") != 0;
    case Cpu::kAvx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vbmi") && __builtin_cpu_supports("avx512vnni");
    case Cpu::kNeon:
      break;
  }
  return false;
}

Cpu best_cpu() {
  for (const Cpu cpu : {Cpu::kAvx512, Cpu::kAvx2, Cpu::kSse4}) {
    if (supported(cpu)) return cpu;
  }
  return Cpu::kScalar;
}

TileKernel<Xrgb> tile_kernel(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
      return run_tile_sse4;
    case Cpu::kAvx2:
      return run_tile_avx2;
    case Cpu::kAvx512:
      return run_tile_avx512;
    default:
      return run_tile_scalar;
  }
}

TileKernel<Rgb16> wide_kernel(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
      return run_wide_sse4;
    case Cpu::kAvx2:
      return run_wide_avx2;
    case Cpu::kAvx512:
      return run_wide_avx512;
    default:
      return run_wide_scalar;
  }
}

TileKernel<Rgb16> linear_kernel(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
      return run_linear_sse4;
    case Cpu::kAvx2:
      return run_linear_avx2;
    case Cpu::kAvx512:
      return run_linear_avx512;
    default:
      return run_linear_scalar;
  }
}

TileKernel<Rgb16> wide_linear_kernel(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
      return run_wide_linear_sse4;
    case Cpu::kAvx2:
    case Cpu::kAvx512:  // texel by texel in any case
      return run_wide_linear_avx2;
    default:
      return run_wide_linear_scalar;
  }
}

RowStore<Xrgb> row_store(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
    case Cpu::kAvx2:
      return {store_row_sse4, finish_rows_streamed};
    case Cpu::kAvx512:
      return {store_row_avx512, finish_rows_streamed};
    default:
      return {store_row_scalar, finish_rows_scalar};
  }
}

RowStore<Rgb16> wide_row_store(Cpu cpu, Narrowing narrowing) {
  switch (cpu) {
    case Cpu::kSse4:
    case Cpu::kAvx2:
      return {wide_store<narrow_rounded_sse4, narrow_dithered_sse4, store_row_sse4, store_row_deep_sse4>(
                  narrowing),
              finish_rows_streamed};
    case Cpu::kAvx512:
      return {wide_store<narrow_rounded_sse4, narrow_dithered_sse4, store_row_avx512, store_row_deep_sse4>(
                  narrowing),
              finish_rows_streamed};
    default:
      return {wide_store<narrow_rounded_scalar, narrow_dithered_scalar, store_row_scalar, store_row_deep>(
                  narrowing),
              finish_rows_scalar};
  }
}

}  // namespace cupola
