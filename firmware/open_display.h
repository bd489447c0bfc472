// The display that a show is played on.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "firmware/command_queue.h"
#include "firmware/show.h"
#include "hal/display/display.h"
#include "hal/time/clock.h"
#include "pipeline/frame/y4m_writer.h"

namespace cupola {

// `kind`: auto, kms, window, file or fake. With file, `out` is a folder, FILE.y4m or "-"; for the latter two
// `video` is made, in frames at `rate`. `commands` gets what a window's keys command. All of them outlive the
// display. Throws Failure, or std::runtime_error from the display itself.
std::unique_ptr<Display> open_display(const std::string& kind, const std::string& out, Clock& clock,
                                      const Show& show, double rate, std::optional<Y4mWriter>& video,
                                      CommandQueue& commands);

}  // namespace cupola
