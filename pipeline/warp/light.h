// From sRGB to light and back, by tables: what filtering in linear light looks texels up in.
//
// Light is linear in 16 bits. 8 bits of sRGB go there and back unchanged: where the curve is flattest in
// light, near black, a step of sRGB is 19.9 steps of light, so that rounding to whole ones is off by at most
// 0.026 steps of sRGB. 16 bits of sRGB lose up to 6.5 of their steps there (0.025 of an 8-bit one).
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace cupola {

struct LightOfSrgb8 {
  alignas(64) std::array<std::uint16_t, 256> words;
  alignas(64) std::array<std::uint8_t, 256> low;  // the words' bytes
  alignas(64) std::array<std::uint8_t, 256> high;
};
extern const LightOfSrgb8 kLightOfSrgb8;

// The larger tables, made when they are first asked for.
struct LightTables {
  std::array<std::uint16_t, 65536> light_of_srgb16;
  std::array<std::uint16_t, 65536> srgb16_of_light;
  std::array<std::uint8_t, 65536> srgb8_of_light;
};
const LightTables& light_tables();

}  // namespace cupola
