// Commands on their way from any thread to the frame loop.
// SPDX-License-Identifier: MIT
#pragma once

#include "firmware/bounded_queue.h"
#include "firmware/player_command.h"

namespace cupola {

using CommandQueue = BoundedQueue<PlayerCommand, 64>;

}  // namespace cupola
