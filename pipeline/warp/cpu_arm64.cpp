// What an AArch64 machine can run: every one has NEON.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/row_store_wide.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

bool supported(Cpu cpu) {
  return cpu == Cpu::kScalar || cpu == Cpu::kNeon;
}

Cpu best_cpu() {
  return Cpu::kNeon;
}

TileKernel<Xrgb> tile_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_tile_neon : run_tile_scalar;
}

// Of 16 bits: SSE4.1's, whose intrinsics are NEON's here (sse4.h).
TileKernel<Rgb16> wide_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_wide_sse4 : run_wide_scalar;
}

TileKernel<Rgb16> linear_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_linear_sse4 : run_linear_scalar;
}

TileKernel<Rgb16> wide_linear_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_wide_linear_sse4 : run_wide_linear_scalar;
}

RowStore<Xrgb> row_store(Cpu cpu) {
  return {cpu == Cpu::kNeon ? store_row_neon : store_row_scalar, finish_rows_scalar};
}

RowStore<Rgb16> wide_row_store(Cpu cpu, Narrowing narrowing) {
  return {cpu == Cpu::kNeon
              ? wide_store<narrow_rounded_sse4, narrow_dithered_sse4, store_row_neon, store_row_deep_sse4>(
                    narrowing)
              : wide_store<narrow_rounded_scalar, narrow_dithered_scalar, store_row_scalar, store_row_deep>(
                    narrowing),
          finish_rows_scalar};
}

}  // namespace cupola
