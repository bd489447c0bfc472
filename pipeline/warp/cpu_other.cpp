// Machines for which there is the scalar kernel only.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/row_store.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

bool supported(Cpu cpu) {
  return cpu == Cpu::kScalar;
}
Cpu best_cpu() {
  return Cpu::kScalar;
}
TileKernel<Xrgb> tile_kernel(Cpu) {
  return run_tile_scalar;
}

RowStore<Xrgb> row_store(Cpu) {
  return {store_row_scalar, finish_rows_scalar};
}

}  // namespace cupola
