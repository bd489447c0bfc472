// The kernel's lines on a machine that may have none.
// SPDX-License-Identifier: MIT
#include "hal/gpio/gpiod_lines.h"

#include <cerrno>

#include <gtest/gtest.h>

namespace cupola {
namespace {

TEST(GpiodLines, SayThatALineIsMissing) {
  MonotonicClock clock;
  const std::unique_ptr<Gpio> gpio = make_gpiod_lines(clock);
  std::vector<GpioLine> lines(1);
  lines[0].name = "a line that no machine has";
  const auto started = gpio->start(lines);
  const auto* trouble = std::get_if<GpioTrouble>(&started);
  ASSERT_TRUE(trouble);
  EXPECT_NE(trouble->cause, GpioCause::kBusy);
  EXPECT_FALSE(describe(*trouble, lines).empty());
  EXPECT_EQ(gpio->descriptor(), -1);
  GpioEdge edge;
  GpioTrouble later;
  EXPECT_EQ(gpio->poll(edge, later), GpioPoll::kNothing);
}

TEST(GpioTrouble, IsSaidInWords) {
  std::vector<GpioLine> lines(2);
  lines[0].name = "lamp-enable";
  lines[1].chip = "soc";
  lines[1].offset = 4;
  EXPECT_EQ(describe(GpioTrouble{GpioCause::kMissing, "no such chip", 0, 0}, lines),
            "lamp-enable: not there (no such chip)");
  EXPECT_EQ(describe(GpioTrouble{GpioCause::kBusy, "request", EBUSY, 1}, lines),
            "chip soc, line 4: taken by somebody else (request: Device or resource busy)");
  EXPECT_EQ(describe(GpioTrouble{GpioCause::kGone, "poll", 0, -1}, lines), "the chip is gone (poll)");
}

}  // namespace
}  // namespace cupola
