// SSE4.1's intrinsics: the processor's own, or on AArch64 SIMDe's, which are NEON's under their names.
// SPDX-License-Identifier: MIT
#pragma once

#ifdef __aarch64__
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/sse4.1.h>
#else
#include <smmintrin.h>
#endif
