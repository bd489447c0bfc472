// A show's file read again while it plays: the new show is made ready beside the frame loop, which takes it
// between two flips.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "firmware/event_log.h"
#include "firmware/frame_maker.h"
#include "firmware/handover.h"
#include "firmware/player_status.h"
#include "firmware/show_facts.h"
#include "firmware/side_work.h"
#include "firmware/snapshot.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

struct ReadyShow {
  std::optional<WorkerPool> pool;     // the one that `maker` borrows; none: somebody else's
  std::unique_ptr<FrameMaker> maker;  // ends before it
  ShowFacts facts;
  std::vector<std::optional<std::size_t>> places;  // by name: of each cue of the show before
};

class ShowReload {
 public:
  // Makes `maker` and `facts` of a `ready` that has a pool; throws where the show is not to be had. Called
  // on a thread of the lowest priority, whose pool is of that priority too. Where the show begins threads of
  // its own, which would keep that, nothing but the tables in the cache may come of it: true is returned, and
  // it is called once more from a thread of the program's own priority with `for_good`.
  using Open = std::function<bool(ReadyShow& ready, bool for_good)>;
  // Gives the threads of the pool that the show will be played with what the loop's have. Called on a thread
  // of its own.
  using Settle = std::function<void(WorkerPool& pool)>;
  // `first` is what the loop plays, with `threads` threads; `status` and `log` are borrowed.
  ShowReload(std::unique_ptr<ReadyShow> first, Open open, Settle settle, int threads, Size frame,
             const Snapshot<PlayerStatus>& status, EventLog& log);

  // The loop's; none waits or allocates.
  void ask() noexcept;
  ReadyShow* take() noexcept { return handover_.take(); }
  // The loop plays that one now, and uses nothing of the one before.
  void taken(ReadyShow* ready) noexcept;

  // Anybody's.
  ShowFacts facts() const;  // of the show that plays
  std::string trouble()
      const;            // why the last reload changed nothing; empty where it did, or none was asked for
  int reloads() const;  // that went well

  // After the loop's end: the show that it played last. No reload begins after it.
  const FrameMaker& end();

 private:
  void work() noexcept;
  void settle_taken();
  std::unique_ptr<ReadyShow> open_ready();
  void warm_up(ReadyShow& ready) const;
  void refuse(const std::string& why);

  Open open_;
  Settle settle_;
  int threads_;
  Size frame_;
  const Snapshot<PlayerStatus>& status_;
  EventLog& log_;
  std::atomic<bool> asked_{false};
  Handover<ReadyShow> handover_;
  // The side's:
  std::unique_ptr<ReadyShow> current_;
  std::unique_ptr<ReadyShow> fresh_;
  // Everybody's but the loop's:
  mutable std::mutex mutex_;
  ShowFacts facts_;
  std::string trouble_;
  int reloads_ = 0;
  std::optional<SideWork> side_;  // last: it uses the others
};

struct Show;
class TableCache;
enum class Cpu : std::uint8_t;

// Reads the show again as it was read first, for a loop in real time whose frames are `now`'s. Throws
// InputError where the file or its pictures are wrong, and where what has changed needs a new start: the
// frame's size, the projector, a live show, sound, filter.budget_ms.
ShowReload::Open reopen_show(const Show& now, std::string file, std::vector<std::string> overrides,
                             std::string rig, std::string display, Cpu cpu, const TableCache& cache);

}  // namespace cupola
