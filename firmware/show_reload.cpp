// What takes time is done before the loop hears of the new show and after it has left the old one.
// SPDX-License-Identifier: MIT
#include "firmware/show_reload.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <thread>

#include "firmware/control_answers.h"
#include "firmware/show.h"
#include "firmware/show_frames.h"
#include "pipeline/frame/error.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

namespace {

// On a thread that ends with it; what it throws is thrown here.
template <class Task>
void apart(Task task) {
  std::exception_ptr error;
  std::thread([&] {
    try {
      task();
    } catch (...) {
      error = std::current_exception();
    }
  }).join();
  if (error) std::rethrow_exception(error);
}

constexpr auto kPatience = 5s;  // for the first faces

bool same_projector(const ProjectorSettings& a, const ProjectorSettings& b) {
  return a.card == b.card && a.connector == b.connector && a.mode.width == b.mode.width &&
         a.mode.height == b.mode.height && a.mode.rate == b.mode.rate;
}

}  // namespace

ShowReload::ShowReload(std::unique_ptr<ReadyShow> first, Open open, Settle settle, int threads, Size frame,
                       const Snapshot<PlayerStatus>& status, EventLog& log)
    : open_(std::move(open)),
      settle_(std::move(settle)),
      threads_(threads),
      frame_(frame),
      status_(status),
      log_(log),
      current_(std::move(first)),
      facts_(current_->facts) {
  side_.emplace([this] { work(); }, false);
}

void ShowReload::ask() noexcept {
  asked_.store(true);
  side_->ring();
}

void ShowReload::taken(ReadyShow* ready) noexcept {
  handover_.give_back(ready);
  side_->ring();
}

ShowFacts ShowReload::facts() const {
  const std::lock_guard lock(mutex_);
  return facts_;
}

std::string ShowReload::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

int ShowReload::reloads() const {
  const std::lock_guard lock(mutex_);
  return reloads_;
}

const FrameMaker& ShowReload::end() {
  side_.reset();
  settle_taken();
  return *current_->maker;
}

void ShowReload::settle_taken() {
  if (!handover_.returned()) return;
  current_ = std::move(fresh_);  // the one before ends here
  const std::lock_guard lock(mutex_);
  facts_ = current_->facts;
  trouble_.clear();
  ++reloads_;
}

void ShowReload::refuse(const std::string& why) {
  log_.warn(Topic::kShow, fmt::format("reload: {}; the show goes on as it was", why));
  const std::lock_guard lock(mutex_);
  trouble_ = why;
}

void ShowReload::work() noexcept {
  try {
    const bool taken = fresh_ != nullptr;
    settle_taken();
    if (taken && !fresh_) log_.notice(Topic::kShow, "reload: the show was read again");
    if (fresh_ || !asked_.exchange(false)) return;  // what is not taken yet rings when it is
    fresh_ = open_ready();
    handover_.offer(fresh_.get());
  } catch (const std::exception& error) {
    refuse(error.what());
  }
}

// On threads of their own, as a thread's priority can be lowered, but not raised again.
std::unique_ptr<ReadyShow> ShowReload::open_ready() {
  auto ready = std::make_unique<ReadyShow>();
  bool again = false;
  apart([&] {
    setpriority(PRIO_PROCESS, 0, 19);  // on Linux: this thread's, and those that it begins
    ready->pool.emplace(threads_);
    again = open_(*ready, false);
    if (again) {
      ready->maker.reset();
    } else {
      warm_up(*ready);
    }
  });
  apart([&] {
    ready->pool.emplace(threads_);  // in the same place: what borrows the one before borrows this one
    if (again) {
      open_(*ready, true);
      warm_up(*ready);
    }
    settle_(*ready->pool);
  });
  return ready;
}

// Finds the cues of the show before, decodes about where the loop will go on, and pages in what a warp looks
// at.
void ShowReload::warm_up(ReadyShow& ready) const {
  const std::vector<std::string>& cues = ready.facts.cues;
  for (const std::string& name : current_->facts.cues) {
    const auto found = std::find(cues.begin(), cues.end(), name);
    ready.places.push_back(
        found == cues.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - cues.begin())));
  }
  const ShowReport now = status_.read().show;
  const std::optional<std::size_t> place = ready.places[now.cue];
  const std::array<PlayerCommand, 2> there = {
      PlayerCommand{PlayerAction::kCue, {}, place.value_or(0)},
      PlayerCommand{PlayerAction::kSeek, place ? now.position : nanoseconds(0)}};
  FrameMaker::Change change = ready.maker->advance({nanoseconds(0), nanoseconds(0), there});
  for (const auto until = std::chrono::steady_clock::now() + kPatience;
       change == FrameMaker::Change::kUnchanged && std::chrono::steady_clock::now() < until;) {
    std::this_thread::sleep_for(1ms);
    change = ready.maker->advance({});
  }
  if (change == FrameMaker::Change::kFailed) {
    ShowReport report;
    ready.maker->report(report);
    throw Failure(report.trouble.data());
  }
  if (change != FrameMaker::Change::kNew) return;
  ImageBuffer frame(PixelFormat::kXrgb8888, frame_);
  ready.maker->warp(frame.pixels(), 0);
}

ShowReload::Open reopen_show(const Show& now, std::string file, std::vector<std::string> overrides,
                             std::string rig, std::string display, Cpu cpu, const TableCache& cache) {
  return [size = now.rig.frame.size, sounds = now.sounds(), projector = now.devices.projector,
          file = std::move(file), overrides = std::move(overrides), rig = std::move(rig),
          display = std::move(display), cpu, cache = cache](ReadyShow& ready, bool for_good) mutable {
    const Show show = load_show(file, overrides, rig);
    if (show.live()) throw InputError(fmt::format("{}: a live show needs a new start", show.file.string()));
    if (sounds || show.sounds()) {
      throw InputError(fmt::format("{}: a show with sound needs a new start", show.file.string()));
    }
    const Size fresh = show.rig.frame.size;
    if (fresh != size) {
      throw InputError(fmt::format("{}: frame: {} x {} instead of {} x {} needs a new start",
                                   show.rig.file.string(), fresh.width, fresh.height, size.width,
                                   size.height));
    }
    if (!same_projector(show.devices.projector, projector)) {
      throw InputError(fmt::format("{}: display: other settings need a new start", show.rig.file.string()));
    }
    if (show.rig.budget_ms) {
      throw InputError(
          fmt::format("{}: filter.budget_ms: is measured on a machine at rest: needs a new start",
                      show.rig.file.string()));
    }
    // Files are decoded by threads of their own.
    const bool decoders = std::any_of(show.cues.begin(), show.cues.end(),
                                      [](const Cue& cue) { return cue.source <= CueSource::kVideo; });
    const Decoding decoding = decoders && !for_good ? Decoding::kInTurn : Decoding::kAhead;
    ready.maker = std::make_unique<ShowFrames>(show, Method::kEwa, cpu, *ready.pool, false, &cache, decoding);
    ready.facts = facts_of(show, display);
    return decoders && !for_good;
  };
}

}  // namespace cupola
