// What a show asks of the machine: read strictly, taken where the machine gives it.
// SPDX-License-Identifier: MIT
#include "firmware/machine_settings.h"

#include <gmock/gmock.h>
#include <pthread.h>
#include <sched.h>

#include <barrier>
#include <mutex>
#include <set>
#include <thread>

#include "firmware/show.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using testing::HasSubstr;

MachineSettings machine_of(std::vector<std::string> lines) {
  return load_show("demo", lines).machine;
}

TEST(MachineSettings, AreNoneUnlessTheShowAsksForThem) {
  const MachineSettings machine = machine_of({});
  EXPECT_EQ(machine.priority, 0);
  EXPECT_FALSE(machine.lock_memory);
  EXPECT_TRUE(machine.cores.empty());
}

TEST(MachineSettings, AreReadFromTheShow) {
  const MachineSettings machine =
      machine_of({"machine.priority=50", "machine.lock_memory=true", "machine.cores=[1, 0]"});
  EXPECT_EQ(machine.priority, 50);
  EXPECT_TRUE(machine.lock_memory);
  EXPECT_EQ(machine.cores, (std::vector<int>{1, 0}));
}

TEST(MachineSettings, AreRefusedWhereNoMachineHasThem) {
  const std::pair<const char*, const char*> wrong[] = {
      {"machine.priority=100", "machine.priority"},     {"machine.priority=-1", "machine.priority"},
      {"machine.lock_memory=3", "machine.lock_memory"}, {"machine.cores=[]", "machine.cores"},
      {"machine.cores=[0.5]", "machine.cores"},         {"machine.cores=[-1]", "machine.cores"},
      {"machine.cores=[1024]", "machine.cores"},        {"machine.core=[0]", "did you mean cores?"}};
  for (const auto& [line, words] : wrong) {
    try {
      machine_of({line});
      ADD_FAILURE() << line;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words)) << line;
    }
  }
}

struct Place {
  int policy = 0;
  int priority = 0;
  std::set<int> cores;
};

Place place_of_this_thread() {
  Place place;
  sched_param param{};
  place.policy = sched_getscheduler(0);  // the kernel's word: the C library remembers what it was told
  sched_getparam(0, &param);
  place.priority = param.sched_priority;
  cpu_set_t set;
  pthread_getaffinity_np(pthread_self(), sizeof set, &set);
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(static_cast<std::size_t>(core), &set)) place.cores.insert(core);
  }
  return place;
}

// On a thread of its own: what it takes is for good.
TEST(MachineSettings, SettleEveryThreadOfTheLoopOrSayWhyNot) {
  const int core = *place_of_this_thread().cores.rbegin();
  std::thread([core] {
    WorkerPool pool(3);
    MachineSettings machine;
    machine.priority = 1;
    machine.cores = {core};
    const std::vector<std::string> refused = settle(machine, pool);
    std::barrier everybody(3);
    std::mutex mutex;
    std::vector<Place> places;
    pool.run(3, [&](int) {
      {
        const std::lock_guard lock(mutex);
        places.push_back(place_of_this_thread());
      }
      everybody.arrive_and_wait();
    });
    ASSERT_EQ(places.size(), 3U);
    for (const Place& place : places) {
      EXPECT_EQ(place.cores, std::set<int>{core});
      if (refused.empty()) {
        EXPECT_EQ(place.policy & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
        EXPECT_EQ(place.priority, 1);
      }
    }
    if (refused.empty()) {
      std::thread([] { EXPECT_EQ(place_of_this_thread().policy, SCHED_OTHER) << "inherited"; }).join();
    } else {
      ASSERT_EQ(refused.size(), 1U) << "once, not once a thread";
      EXPECT_THAT(refused[0], HasSubstr("machine.priority: 1 is refused: Operation not permitted"));
    }
  }).join();
}

TEST(MachineSettings, SayWhichCoreIsNotThere) {
  WorkerPool pool(2);
  MachineSettings machine;
  machine.cores = {CPU_SETSIZE - 1};
  const std::vector<std::string> refused = settle(machine, pool);
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_THAT(refused[0], HasSubstr("machine.cores: core 1023 is not to be had: Invalid argument"));
}

TEST(MachineSettings, AskNothingOfAnyThreadByThemselves) {
  WorkerPool pool(2);
  const Place before = place_of_this_thread();
  EXPECT_TRUE(settle({}, pool).empty());
  EXPECT_EQ(place_of_this_thread().policy, before.policy);
  EXPECT_EQ(place_of_this_thread().cores, before.cores);
}

}  // namespace
}  // namespace cupola
