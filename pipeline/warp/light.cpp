// The sRGB curve, rounded to nearest at every entry.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/light.h"

#include <memory>

#include "pipeline/frame/srgb_curve.h"

namespace cupola {
namespace {

template <class Sample>
Sample rounded(double value, double most) {
  return static_cast<Sample>(value * most + 0.5);
}

LightOfSrgb8 make_light_of_srgb8() {
  LightOfSrgb8 table{};
  for (std::size_t i = 0; i < 256; ++i) {
    const auto light = rounded<std::uint16_t>(light_of_srgb(static_cast<double>(i) / 255.0), 65535.0);
    table.words[i] = light;
    table.low[i] = static_cast<std::uint8_t>(light);
    table.high[i] = static_cast<std::uint8_t>(light >> 8);
  }
  return table;
}

std::unique_ptr<const LightTables> make_light_tables() {
  auto tables = std::make_unique<LightTables>();
  for (std::size_t i = 0; i < 65536; ++i) {
    const double value = static_cast<double>(i) / 65535.0;
    const double srgb = srgb_of_light(value);
    tables->light_of_srgb16[i] = rounded<std::uint16_t>(light_of_srgb(value), 65535.0);
    tables->srgb16_of_light[i] = rounded<std::uint16_t>(srgb, 65535.0);
    tables->srgb8_of_light[i] = rounded<std::uint8_t>(srgb, 255.0);
  }
  return tables;
}

}  // namespace

const LightOfSrgb8 kLightOfSrgb8 = make_light_of_srgb8();

const LightTables& light_tables() {
  static const std::unique_ptr<const LightTables> tables = make_light_tables();
  return *tables;
}

}  // namespace cupola
