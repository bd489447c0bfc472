// The picture of one view as the warp reads it, whatever its format.
// SPDX-License-Identifier: MIT
#pragma once

#include <variant>

#include "pipeline/frame/image.h"
#include "pipeline/frame/native_image.h"
#include "pipeline/optics/view.h"

namespace cupola {

// As a camera sends it: of the picture no more than the texels `there` need be in memory.
struct NativePart {
  NativeImage picture;
  TexelBox there;
};

// Borrowed, or none at all.
using FacePicture = std::variant<std::monostate, Image, NativePart>;

}  // namespace cupola
