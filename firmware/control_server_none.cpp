// A program that was built without HTTP.
// SPDX-License-Identifier: MIT
#include "firmware/control_server.h"
#include "pipeline/frame/error.h"

namespace cupola {

std::unique_ptr<ControlServer> start_control_server(const ControlAddress& /*address*/, std::string /*token*/,
                                                    ShowFacts /*facts*/, ControlLink& /*link*/,
                                                    Clock& /*clock*/) {
  throw Failure("control: this program was built without HTTP");
}

std::string ask_status(const ControlAddress& /*address*/, const std::string& /*token*/) {
  throw Failure("status: this program was built without HTTP");
}

}  // namespace cupola
