// The player's ear for OSC over UDP: lighting desks, tablets, show control.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "firmware/control_link.h"
#include "firmware/control_settings.h"
#include "firmware/show_facts.h"
#include "hal/time/clock.h"
#include "hal/time/wall_time.h"

namespace cupola {

// Has a thread of its own, at low priority. Hears until it is destroyed.
class OscServer {
 public:
  virtual ~OscServer() = default;
  virtual const ControlAddress& address() const = 0;  // with the port that it got
};

// How far ahead of its time a bundle may come.
constexpr std::chrono::seconds kFarthestAhead{10};

// `link` and `clock` (real time) are borrowed for the server's life; `time_of_day` is what bundles' times are
// of. With a `token` only addresses that begin with it count. Throws InputError for an address that others
// can reach without a token, Failure where it cannot listen, and where the program was built without OSC.
std::unique_ptr<OscServer> start_osc_server(const ControlAddress& address, std::string token, ShowFacts facts,
                                            ControlLink& link, Clock& clock,
                                            std::function<WallTime()> time_of_day = wall_time);

}  // namespace cupola
