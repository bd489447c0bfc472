// Files and sockets, where waiting for them harms nobody.
// SPDX-License-Identifier: MIT
#include "firmware/player_watch.h"

#include <algorithm>

#include "hal/time/boot_time.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"

namespace cupola {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

namespace {

constexpr nanoseconds kTurn = 100ms;
constexpr nanoseconds kShortestTurn = 10ms;
constexpr nanoseconds kOften = 1s;  // between two writings where only time has passed

bool dark(const PlayerStatus& status) {
  return status.black || status.light <= 0.0;
}

bool held(const PlayerStatus& status) {
  return status.state == PlayerState::kPaused;
}

}  // namespace

PlayerWatch::PlayerWatch(ControlLink& link, ServiceNotice& notice, ShowFacts facts,
                         std::filesystem::path file)
    : link_(link), notice_(notice), facts_(std::move(facts)), file_(std::move(file)) {
  thread_ = std::thread([this] { run(); });
}

PlayerWatch::~PlayerWatch() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  stopping_.notify_all();
  thread_.join();
  notice_.say("STOPPING=1");
}

void PlayerWatch::run() {
  // Four signs of life within the time that systemd waits for one.
  const nanoseconds turn =
      std::clamp(notice_.watchdog().value_or(4 * kTurn) / 4, kShortestTurn, nanoseconds(kTurn));
  std::unique_lock lock(mutex_);
  while (!stopping_.wait_for(lock, turn, [this] { return stop_; })) look(link_.status.read());
}

void PlayerWatch::look(const PlayerStatus& status) {
  const std::int64_t frames = status.counts.frames_presented + status.counts.frames_unshown;
  if (frames == 0) return;
  if (link_.reload) facts_ = link_.reload->facts();
  if (!ready_) ready_ = notice_.say("READY=1");
  if (frames != frames_ && notice_.watchdog()) notice_.say("WATCHDOG=1");
  frames_ = frames;
  if (file_.empty() || status.state == PlayerState::kOver) return;
  const bool changed = !keeps_ || status.state != kept_.state || status.show.cue != kept_.show.cue ||
                       dark(status) != dark(kept_) || status.volume != kept_.volume;
  const bool moved = status.show.position != kept_.show.position;
  if (changed || (moved && time_since_boot() - written_ >= kOften)) keep(status);
}

void PlayerWatch::keep(const PlayerStatus& status) {
  ShowPosition position;
  position.show = facts_.show;
  position.cue = status.show.cue;
  position.cue_name = status.show.cue < facts_.cues.size() ? facts_.cues[status.show.cue] : "";
  position.position = status.show.position;
  position.held = held(status);
  position.dark = dark(status);
  position.volume = status.volume;
  position.at = instant_now();
  // The position is that of the last flip, which is past.
  const nanoseconds since = position.at.booted - time_asleep() - status.shown_at;
  position.at.booted -= since;
  position.at.wall -= since;
  kept_ = status;
  keeps_ = true;
  written_ = time_since_boot();
  try {
    AtomicFile file(file_);
    file.write(position_text(position));
    file.commit();
    if (failed_) link_.log.notice(Topic::kMachine, "the position is kept again");
    failed_ = false;
  } catch (const Failure& error) {
    if (!failed_) link_.log.warn(Topic::kMachine, std::string("the position is not kept: ") + error.what());
    failed_ = true;
  }
}

}  // namespace cupola
