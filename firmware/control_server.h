// The player's own web server: the control page, commands, status, preview and metrics.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "firmware/control_answers.h"
#include "firmware/control_link.h"
#include "firmware/control_settings.h"
#include "hal/time/clock.h"

namespace cupola {

// Has threads of its own, at low priority; none of them touches a file. Answers until it is destroyed.
class ControlServer {
 public:
  virtual ~ControlServer() = default;
  virtual const ControlAddress& address() const = 0;  // with the port that it got
};

// `link` and `clock` (real time) are borrowed for the server's life. An empty `token`: everybody who may
// speak to a loopback address. Throws InputError for any other address without a token, Failure where it
// cannot listen, and where the program was built without HTTP.
std::unique_ptr<ControlServer> start_control_server(const ControlAddress& address, std::string token,
                                                    ShowFacts facts, ControlLink& link, Clock& clock);

// The status of a player, as it answers under /api/status. Throws Failure.
std::string ask_status(const ControlAddress& address, const std::string& token);

// control_page.html
extern const char* const kControlPage;

}  // namespace cupola
