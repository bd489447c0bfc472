// A program that was built without libgpiod has no lines.
// SPDX-License-Identifier: MIT
#include "hal/gpio/gpiod_chips.h"
#include "hal/gpio/gpiod_lines.h"

namespace cupola {
namespace {

class NoLines final : public Gpio {
 public:
  std::variant<GpioLevels, GpioTrouble> start(std::span<const GpioLine>) noexcept override {
    return GpioTrouble{GpioCause::kFailed, "this program was built without libgpiod"};
  }
  void stop() noexcept override {}
  GpioPoll poll(GpioEdge&, GpioTrouble&) noexcept override { return GpioPoll::kNothing; }
  std::optional<GpioTrouble> set(std::size_t, bool) noexcept override { return std::nullopt; }
  int descriptor() const noexcept override { return -1; }
};

}  // namespace

std::unique_ptr<Gpio> make_gpiod_lines(Clock&) {
  return std::make_unique<NoLines>();
}

std::vector<GpioChip> list_gpio_chips() {
  return {};
}

}  // namespace cupola
