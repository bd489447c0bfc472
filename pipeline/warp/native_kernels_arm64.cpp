// The kernels for native pictures on AArch64: those of SSE4.1, whose intrinsics are NEON's there (sse4.h).
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rows.h"

namespace cupola {

TileKernel<Xrgb> rgb_kernel(Cpu cpu, int step) {
  if (cpu != Cpu::kNeon) return run_tile_scalar;
  return step == 3 ? run_rgb3_sse4 : run_rgb4_sse4;
}

TileKernel<Luma> luma_kernel(Cpu cpu, int step) {
  if (cpu != Cpu::kNeon) return run_luma_scalar;
  return step == 1 ? run_luma1_sse4 : run_luma2_sse4;
}

TileKernel<Chroma> chroma_kernel(Cpu cpu, int step) {
  if (cpu != Cpu::kNeon) return run_chroma_scalar;
  return step == 1 ? run_chroma1_sse4 : step == 2 ? run_chroma2_sse4 : run_chroma4_sse4;
}

TileKernel<Luma> wide_luma_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_wide_luma_sse4 : run_wide_luma_scalar;
}

TileKernel<Chroma> wide_chroma_kernel(Cpu cpu) {
  return cpu == Cpu::kNeon ? run_wide_chroma_sse4 : run_wide_chroma_scalar;
}

const YuvRows& yuv_rows(Cpu cpu) {
  return cpu == Cpu::kNeon ? kYuvRowsSse4 : kYuvRowsScalar;
}

}  // namespace cupola
