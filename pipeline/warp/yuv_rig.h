// The rigs by which the chroma of YUV pictures is warped: the same rays through views of fewer texels.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/frame/native_image.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// `rig` with its views as their chroma planes in `layout`. The filter also interpolates between the texels,
// as linear interpolation would that came before `rig`'s own filter.
Rig chroma_rig(const Rig& rig, NativeLayout layout);

// The same for a frame that is itself of half the size, an odd one rounded up, with the filter as it is.
// Throws InputError for a frame of odd size that has no centre (maps of the world, cubes).
Rig half_frame_chroma_rig(const Rig& rig, NativeLayout layout);

}  // namespace cupola
