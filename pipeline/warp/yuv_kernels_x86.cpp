// The kernels for luma and chroma on x86-64.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_rows.h"

namespace cupola {

TileKernel<Luma> luma_kernel(Cpu cpu, int step) {
  if (cpu != Cpu::kAvx512) return run_luma_scalar;
  return step == 1 ? run_luma1_avx512 : run_luma2_avx512;
}

TileKernel<Chroma> chroma_kernel(Cpu cpu, int step) {
  if (cpu != Cpu::kAvx512) return run_chroma_scalar;
  return step == 1 ? run_chroma1_avx512 : step == 2 ? run_chroma2_avx512 : run_chroma4_avx512;
}

const YuvRows& yuv_rows(Cpu cpu) {
  return cpu == Cpu::kAvx512 ? kYuvRowsAvx512 : kYuvRowsScalar;
}

}  // namespace cupola
