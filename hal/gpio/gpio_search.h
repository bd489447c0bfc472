// Finding a line among the chips that are there.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hal/gpio/gpio.h"

namespace cupola {

struct GpioChipNames {
  std::string_view name;  // "gpiochip0"
  std::string_view label;
  std::size_t lines = 0;
};

struct FoundLine {
  std::size_t chip = 0;
  unsigned offset = 0;
};

// `offset_of(chip, name)`: of the line of that name on the chip, or -1. A name that several chips have is
// refused: which of them came first would change from plug to plug.
template <class OffsetOf>
std::variant<FoundLine, GpioTrouble> find_line(const GpioLine& line, std::span<const GpioChipNames> chips,
                                               OffsetOf offset_of) {
  bool chip_there = false;
  std::size_t places = 0;
  FoundLine found;
  for (std::size_t i = 0; i < chips.size(); ++i) {
    if (!line.chip.empty() && line.chip != chips[i].name && line.chip != chips[i].label) continue;
    chip_there = true;
    const int offset = line.offset >= 0 ? line.offset : offset_of(i, line.name);
    if (offset < 0 || static_cast<std::size_t>(offset) >= chips[i].lines) continue;
    found = {i, static_cast<unsigned>(offset)};
    ++places;
  }
  if (places == 1) return found;
  if (places > 1) return GpioTrouble{GpioCause::kFailed, "several chips have it: name the chip, too"};
  return GpioTrouble{GpioCause::kMissing, chip_there ? "no such line" : "no such chip"};
}

// /dev/gpiochip0, ... in the order of their numbers.
std::vector<std::string> gpio_chip_paths();

}  // namespace cupola
