// A program that was built without OSC.
// SPDX-License-Identifier: MIT
#include "firmware/osc_server.h"
#include "pipeline/frame/error.h"

namespace cupola {

std::unique_ptr<OscServer> start_osc_server(const ControlAddress& /*address*/, std::string /*token*/,
                                            ShowFacts /*facts*/, ControlLink& /*link*/, Clock& /*clock*/,
                                            std::function<WallTime()> /*time_of_day*/) {
  throw Failure("control: this program was built without OSC");
}

}  // namespace cupola
