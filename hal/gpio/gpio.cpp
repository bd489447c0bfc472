// What to tell people about lines.
// SPDX-License-Identifier: MIT
#include "hal/gpio/gpio.h"

#include <system_error>

namespace cupola {

const char* name_of(GpioCause cause) {
  switch (cause) {
    case GpioCause::kMissing:
      return "not there";
    case GpioCause::kBusy:
      return "taken by somebody else";
    case GpioCause::kGone:
      return "the chip is gone";
    case GpioCause::kFailed:
      break;
  }
  return "failed";
}

std::string describe(const GpioLine& line) {
  if (line.offset < 0) return line.name;
  return "chip " + line.chip + ", line " + std::to_string(line.offset);
}

std::string describe(const GpioTrouble& trouble, std::span<const GpioLine> lines) {
  std::string text;
  const auto line = static_cast<std::size_t>(trouble.line);
  if (trouble.line >= 0 && line < lines.size()) text = describe(lines[line]) + ": ";
  text += name_of(trouble.cause);
  text += std::string(" (") + trouble.step;
  if (trouble.error != 0) text += ": " + std::generic_category().message(trouble.error);
  return text + ")";
}

}  // namespace cupola
