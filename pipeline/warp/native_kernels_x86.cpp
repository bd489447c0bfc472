// The kernels for native pictures on x86-64.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rows.h"

namespace cupola {

TileKernel<Xrgb> rgb_kernel(Cpu cpu, int step) {
  switch (cpu) {
    case Cpu::kSse4:
      return step == 3 ? run_rgb3_sse4 : run_rgb4_sse4;
    case Cpu::kAvx2:
      return step == 3 ? run_rgb3_avx2 : run_rgb4_avx2;
    case Cpu::kAvx512:
      return step == 3 ? run_rgb3_avx512 : run_rgb4_avx512;
    default:
      return run_tile_scalar;
  }
}

TileKernel<Luma> luma_kernel(Cpu cpu, int step) {
  switch (cpu) {
    case Cpu::kSse4:
      return step == 1 ? run_luma1_sse4 : run_luma2_sse4;
    case Cpu::kAvx2:
      return step == 1 ? run_luma1_avx2 : run_luma2_avx2;
    case Cpu::kAvx512:
      return step == 1 ? run_luma1_avx512 : run_luma2_avx512;
    default:
      return run_luma_scalar;
  }
}

TileKernel<Chroma> chroma_kernel(Cpu cpu, int step) {
  switch (cpu) {
    case Cpu::kSse4:
      return step == 1 ? run_chroma1_sse4 : step == 2 ? run_chroma2_sse4 : run_chroma4_sse4;
    case Cpu::kAvx2:
      return step == 1 ? run_chroma1_avx2 : step == 2 ? run_chroma2_avx2 : run_chroma4_avx2;
    case Cpu::kAvx512:
      return step == 1 ? run_chroma1_avx512 : step == 2 ? run_chroma2_avx512 : run_chroma4_avx512;
    default:
      return run_chroma_scalar;
  }
}

// With AVX-512 too: what three channels of 16 bits gain by it, one and two hardly would.
TileKernel<Luma> wide_luma_kernel(Cpu cpu) {
  if (cpu == Cpu::kScalar) return run_wide_luma_scalar;
  return cpu == Cpu::kSse4 ? run_wide_luma_sse4 : run_wide_luma_avx2;
}

TileKernel<Chroma> wide_chroma_kernel(Cpu cpu) {
  if (cpu == Cpu::kScalar) return run_wide_chroma_scalar;
  return cpu == Cpu::kSse4 ? run_wide_chroma_sse4 : run_wide_chroma_avx2;
}

const YuvRows& yuv_rows(Cpu cpu) {
  switch (cpu) {
    case Cpu::kSse4:
    case Cpu::kAvx2:
      return kYuvRowsSse4;
    case Cpu::kAvx512:
      return kYuvRowsAvx512;
    default:
      return kYuvRowsScalar;
  }
}

}  // namespace cupola
