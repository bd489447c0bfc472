// By our own power function.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/srgb_curve.h"

#include "pipeline/portable/portable_math.h"

namespace cupola {

double light_of_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : portable::power((value + 0.055) / 1.055, 2.4);
}

double srgb_of_light(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * portable::power(light, 1.0 / 2.4) - 0.055;
}

}  // namespace cupola
