// What a show may ask of the machine, so that its frames come in time beside other programs.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/parallel/worker_pool.h"
#include "pipeline/settings/settings.h"

namespace cupola {

// The show file's [machine].
struct MachineSettings {
  int priority = 0;          // SCHED_FIFO, 1 to 99; 0: as the program was started
  bool lock_memory = false;  // what is mapped once everything is open is never paged out
  std::vector<int> cores;    // for the frame loop's thread and then the pool's, over and over; empty: any
};

// Throws InputError for values that no machine has.
MachineSettings read_machine(SettingsTable table);

// For the calling thread, which is to run the frame loop, and the pool's; memory is locked for the whole
// program. Threads that are begun later get none of it. Returns a line for everything that the machine
// refuses: the show plays without.
std::vector<std::string> settle(const MachineSettings& machine, WorkerPool& pool);

}  // namespace cupola
