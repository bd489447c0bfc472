// Which GPIO chips there are, for lists.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace cupola {

struct GpioChip {
  std::string path;   // /dev/gpiochip0: the number may change with every plug
  std::string label;  // stays
  int lines = 0;
  std::vector<std::string> line_names;  // of the lines that have one
  std::string trouble;                  // why it cannot be opened; empty: it can
};

// In the order of their numbers; by whichever libgpiod it was built with. Built without: none.
std::vector<GpioChip> list_gpio_chips();

}  // namespace cupola
