// What an AArch64 machine can run: every one has NEON.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/row_store.h"
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

RowStore<Xrgb> row_store(Cpu cpu) {
  return {cpu == Cpu::kNeon ? store_row_neon : store_row_scalar, finish_rows_scalar};
}

}  // namespace cupola
