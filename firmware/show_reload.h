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
#include "firmware/sound_set.h"
#include "hal/sound/sound_output.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

struct ReadyShow {
  std::optional<WorkerPool> pool;     // the one that `maker` borrows; none: somebody else's
  std::unique_ptr<FrameMaker> maker;  // ends before it
  ShowFacts facts;
  std::vector<std::optional<std::size_t>> places;  // by name: of each cue of the show before
  int number = 0;                                  // PlayerStatus::show_number while it plays
  // Opens its sounds for the device that is open, ready to be heard from `place`; throws InputError. Null:
  // there is no such device.
  std::function<std::unique_ptr<SoundSet>(const Timeline::Place& place)> open_sounds;
  std::function<void()> begun;  // called beside the loop once it plays this one; may be null
};

class ShowReload {
 public:
  // Makes `maker`, `facts` and the functions of a `ready` that has a pool; throws where the show is not to be
  // had. Called on a thread of the lowest priority, whose pool is of that priority too; `open_sounds` is
  // called later, on one of the program's own. Where the show's pictures begin threads of their own, which
  // would keep that, nothing but the tables in the cache may come of it: true is returned, and it is called
  // once more from a thread of the program's own priority with `for_good`.
  using Open = std::function<bool(ReadyShow& ready, bool for_good)>;
  // Gives the threads of the pool that the show will be played with what the loop's have. Called on a thread
  // of its own.
  using Settle = std::function<void(WorkerPool& pool)>;
  // `first` is what the loop plays, with `threads` threads; `status` and `log` are borrowed.
  ShowReload(std::unique_ptr<ReadyShow> first, Open open, Settle settle, int threads, Size frame,
             const Snapshot<PlayerStatus>& status, EventLog& log);
  ~ShowReload();

  // The loop's; none waits or allocates.
  void ask() noexcept;
  ReadyShow* take() noexcept { return handover_.take(); }
  // The loop plays that one now, and uses nothing of the one before.
  void taken(ReadyShow* ready) noexcept;

  // The sound's thread's; neither waits or allocates. The set of the show that the loop has not or only just
  // taken, or null; and the one that is not heard any more, to be ended here.
  std::unique_ptr<SoundSet> take_sounds() noexcept { return std::unique_ptr<SoundSet>(sounds_.take()); }
  void sounds_left(std::unique_ptr<SoundSet> old) noexcept;

  // Anybody's.
  ShowFacts facts() const;  // of the show that plays
  std::string trouble()
      const;            // why the last reload changed nothing; empty where it did, or none was asked for
  int reloads() const;  // that went well

  // After the end of the loop and of the sound: the show that it played last. No reload begins after it.
  const FrameMaker& end();

 private:
  void work() noexcept;
  void settle_taken();
  std::unique_ptr<ReadyShow> open_ready();
  void warm_up(ReadyShow& ready) const;
  Timeline::Place place_in(const ReadyShow& ready) const;
  void refuse(const std::string& why);

  Open open_;
  Settle settle_;
  int threads_;
  Size frame_;
  const Snapshot<PlayerStatus>& status_;
  EventLog& log_;
  std::atomic<bool> asked_{false};
  Handover<ReadyShow> handover_;
  Handover<SoundSet> sounds_;  // whoever took one owns it
  // The side's:
  std::unique_ptr<ReadyShow> current_;
  std::unique_ptr<ReadyShow> fresh_;
  bool old_is_heard_ = false;  // still, although its show's successor was offered
  // Everybody's but the loop's:
  mutable std::mutex mutex_;
  ShowFacts facts_;
  std::string trouble_;
  int reloads_ = 0;
  std::optional<SideWork> side_;  // last: it uses the others
};

struct Show;
class PatternBoard;
class TableCache;
enum class Cpu : std::uint8_t;

// Reads the show again as it was read first, for a loop in real time whose frames are `now`'s. Throws
// InputError where the file, its pictures or its sounds are wrong, and where what has changed needs a new
// start: the frame's size, the projector, live cues, a first sound, the sound's device, filter.budget_ms.
// `sound`: what the device takes; none: there is none. `patterns`, borrowed, or null, then draws for the new
// rig.
ShowReload::Open reopen_show(const Show& now, std::string file, std::vector<std::string> overrides,
                             std::string rig, std::string display, Cpu cpu, const TableCache& cache,
                             std::optional<SoundMode> sound, PatternBoard* patterns);

}  // namespace cupola
