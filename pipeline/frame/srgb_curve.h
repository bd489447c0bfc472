// The transfer function of sRGB.
// SPDX-License-Identifier: MIT
#pragma once

namespace cupola {

// IEC 61966-2-1 both ways, over [0, 1]: the same bits on every machine.
double light_of_srgb(double value);
double srgb_of_light(double light);

}  // namespace cupola
