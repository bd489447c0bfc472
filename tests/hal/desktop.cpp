// Xvfb as a child process; it picks a free display number itself.
// SPDX-License-Identifier: MIT
#include "tests/hal/desktop.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace cupola {

Desktop::Desktop() {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("Xvfb: no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 3);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  const char* arguments[] = {"Xvfb",       "-displayfd", "3",   "-screen",  "0",
                             "800x600x24", "-nolisten",  "tcp", "-noreset", nullptr};
  const int error = posix_spawnp(&server_, "Xvfb", &actions, nullptr, const_cast<char**>(arguments), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string number;
  char digit = 0;
  while (error == 0 && read(ends[0], &digit, 1) == 1 && digit != '\n') number += digit;
  close(ends[0]);
  if (number.empty()) throw std::runtime_error("Xvfb does not start");
  setenv("DISPLAY", (":" + number).c_str(), 1);
  setenv("SDL_VIDEODRIVER", "x11", 1);
  setenv("SDL_RENDER_DRIVER", "software", 1);
}

Desktop::~Desktop() {
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
}

}  // namespace cupola
