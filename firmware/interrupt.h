// Signals as values: Ctrl-C and termination are asked for, never jumped to.
// SPDX-License-Identifier: MIT
#pragma once

namespace cupola {

// SIGINT and SIGTERM are noted (a second one ends the program at once); SIGPIPE and SIGXFSZ are ignored, so
// that the write that failed says why.
void catch_interrupts();
bool interrupted() noexcept;

}  // namespace cupola
