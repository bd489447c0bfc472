// The warp of YUV pictures into frames of RGB.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/warp/native_warp.h"

namespace cupola {

// As make_native_to_xrgb_warp(), of one kind of faces.
std::unique_ptr<NativeWarp<MutableImage>> make_yuv_to_xrgb_warp(const Rig& rig, NativeLayout faces, Cpu cpu,
                                                                WorkerPool& pool, TableCache* cache);

}  // namespace cupola
