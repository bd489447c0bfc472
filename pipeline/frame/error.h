// The two ways a start-up can end early; nothing in the frame loop throws either.
// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace cupola {

// The call, a config file or an input is wrong; the text says file, line, key and what was expected. Exit
// code 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Everything asked for was right, yet it could not be done: a full disk, a closed pipe. Exit code 1.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace cupola
