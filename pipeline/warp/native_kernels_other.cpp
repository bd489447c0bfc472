// Machines on which native pictures have scalar kernels only.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rows.h"

namespace cupola {

TileKernel<Xrgb> rgb_kernel(Cpu, int) {
  return run_tile_scalar;
}

TileKernel<Luma> luma_kernel(Cpu, int) {
  return run_luma_scalar;
}

TileKernel<Chroma> chroma_kernel(Cpu, int) {
  return run_chroma_scalar;
}

TileKernel<Luma> wide_luma_kernel(Cpu) {
  return run_wide_luma_scalar;
}

TileKernel<Chroma> wide_chroma_kernel(Cpu) {
  return run_wide_chroma_scalar;
}

const YuvRows& yuv_rows(Cpu) {
  return kYuvRowsScalar;
}

}  // namespace cupola
