// Priority, cores and memory, as Linux gives them.
// SPDX-License-Identifier: MIT
#include "firmware/machine_settings.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <atomic>
#include <barrier>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace cupola {
namespace {

constexpr int kMostCores = CPU_SETSIZE;

// 0 or an errno.
int take_priority(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  // Nobody inherits it: decoders and servers have no deadline.
  return pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted);
}

int take_core(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(core), &set);
  return pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

}  // namespace

MachineSettings read_machine(SettingsTable table) {
  MachineSettings machine;
  machine.priority = static_cast<int>(table.integer("priority", 0, 99, 0));
  machine.lock_memory = table.flag("lock_memory", false);
  if (table.has("cores")) {
    for (const double core : table.numbers("cores", 1, 64)) {
      if (core < 0 || core >= kMostCores || core != std::floor(core)) {
        table.refuse("cores", fmt::format("expected numbers of cores from 0 to {}", kMostCores - 1));
        continue;
      }
      machine.cores.push_back(static_cast<int>(core));
    }
  }
  table.finish();
  return machine;
}

std::vector<std::string> settle(const MachineSettings& machine, WorkerPool& pool) {
  std::vector<std::string> refused;
  std::atomic<int> no_priority{0};
  std::atomic<int> no_core{0};
  std::atomic<int> core_refused{0};
  if (machine.priority > 0 || !machine.cores.empty()) {
    // Nobody passes before everybody has come: so each thread takes one task.
    std::barrier everybody(pool.threads());
    std::atomic<std::size_t> others{0};
    const pthread_t caller = pthread_self();
    pool.run(pool.threads(), [&](int) {
      const std::size_t place = pthread_equal(caller, pthread_self()) ? 0 : ++others;
      if (!machine.cores.empty()) {
        const int core = machine.cores[place % machine.cores.size()];
        if (const int error = take_core(core)) {
          no_core = error;
          core_refused = core;
        }
      }
      if (machine.priority > 0) {
        if (const int error = take_priority(machine.priority)) no_priority = error;
      }
      everybody.arrive_and_wait();
    });
  }
  if (no_core != 0) {
    refused.push_back(
        fmt::format("machine.cores: core {} is not to be had: {}; the show plays on any of the others",
                    core_refused.load(), std::strerror(no_core)));
  }
  if (no_priority != 0) {
    refused.push_back(fmt::format(
        "machine.priority: {} is refused: {}; the show plays at the usual one (root, CAP_SYS_NICE or "
        "LimitRTPRIO={} in the unit file would allow it)",
        machine.priority, std::strerror(no_priority), machine.priority));
  }
  // What is mapped by now: everything that a frame needs. Later mappings are left out, as a limit would make
  // each of them fail.
  if (machine.lock_memory && mlockall(MCL_CURRENT) != 0) {
    refused.push_back(
        fmt::format("machine.lock_memory: refused: {}; the show plays in memory that may be paged out (root, "
                    "CAP_IPC_LOCK or LimitMEMLOCK=infinity in the unit file would allow it)",
                    std::strerror(errno)));
  }
  return refused;
}

}  // namespace cupola
