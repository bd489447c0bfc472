// Linear light as 16 bits of sRGB.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace cupola {

// The curve of IEC 61966-2-1 over [0, 65535], rounded to nearest; light below 0 and what is no number is 0,
// above 1 it is 1.
std::uint16_t srgb16_code(float light);

}  // namespace cupola
