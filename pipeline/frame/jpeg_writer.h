// A picture as the bytes of a JPEG file, for looking at from elsewhere.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "pipeline/frame/image.h"

namespace cupola {

// `image` is kXrgb8888 or kRgb8, of sides up to 65,500; quality 1 to 100. Throws Failure.
std::string encode_jpeg(const Image& image, int quality);

}  // namespace cupola
