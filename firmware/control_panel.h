// The operator's buttons and lamps: GPIO edges become commands for the frame loop, flips become signals.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "firmware/command_queue.h"
#include "firmware/event_log.h"
#include "firmware/rig_devices.h"
#include "hal/gpio/gpio_watch.h"

namespace cupola {

class ControlPanel {
 public:
  // Takes the lines, or says why not and goes on trying. `gpio`, `clock` and `log` are borrowed for the
  // panel's life.
  ControlPanel(const GpioSettings& settings, Gpio& gpio, Clock& clock, EventLog& log);

  // To be called once a frame: what was pressed goes into `commands`; true when the coming frame is to be
  // black, by a line that is active or was meanwhile. Does not wait; allocates only when lines were lost.
  bool poll(CommandQueue& commands) noexcept;
  // To be called after each flip: lamp on, tally on while the show's time runs, shutter shut while the
  // picture is black, camera trigger the other way round than at the flip before.
  void flipped(bool black, bool held) noexcept;
  // After the last one: lamp, tally and trigger off, shutter shut; as before the first.
  void rest() noexcept;

  const GpioCounts& counts() const noexcept { return watch_.counts(); }

 private:
  bool poll_lines(CommandQueue* commands) noexcept;
  void set(OutputIs which, bool active) noexcept;

  std::vector<std::optional<PlayerCommand>> inputs_;  // the watch's first lines
  std::vector<OutputIs> outputs_;                     // the others
  GpioWatch watch_;
  EventLog& log_;
  bool trigger_ = false;
};

}  // namespace cupola
