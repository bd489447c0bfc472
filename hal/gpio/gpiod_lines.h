// The kernel's GPIO character devices, through libgpiod.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "hal/gpio/gpio.h"
#include "hal/time/clock.h"

namespace cupola {

// By libgpiod 1.6 or 2.x, whichever it was built with; built without, every start fails. `clock` is borrowed
// for the lines' life; edges are stamped with CLOCK_MONOTONIC whatever it is.
std::unique_ptr<Gpio> make_gpiod_lines(Clock& clock);

}  // namespace cupola
