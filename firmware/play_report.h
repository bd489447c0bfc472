// What was counted while a show was played, and what its recordings lack.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "firmware/frame_loop.h"
#include "firmware/live_frames.h"
#include "firmware/show_frames.h"
#include "hal/gpio/gpio_watch.h"

namespace cupola {

nlohmann::ordered_json play_stats(const FrameLoop& loop, const GpioCounts& gpio, const ShowFrames& frames);

// On standard error, a line each.
void report_recordings(const LiveFrames& live);

}  // namespace cupola
