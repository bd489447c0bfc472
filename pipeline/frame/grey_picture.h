// A picture of brightnesses alone, in memory of its own.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"

namespace cupola {

struct GreyPicture {
  Size size;
  std::vector<std::uint8_t> texels;  // row by row, without gaps
};

}  // namespace cupola
