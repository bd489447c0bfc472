// A texel and its share of an output pixel.
// SPDX-License-Identifier: MIT
#pragma once

namespace cupola {

struct Tap {
  int x, y;  // texel
  int view;
  double weight;
};

}  // namespace cupola
