// What takes time is done before the loop hears of the new show and after it has left the old one.
// SPDX-License-Identifier: MIT
#include "firmware/show_reload.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <thread>

#include "firmware/control_answers.h"
#include "firmware/open_sound.h"
#include "firmware/pattern_board.h"
#include "firmware/show.h"
#include "firmware/show_frames.h"
#include "hal/time/clock.h"
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
         a.mode.height == b.mode.height && a.mode.rate == b.mode.rate && a.nv12 == b.nv12;
}

// What a sound device was opened for at the start.
void expect_same_sound(const Show& show, bool sounded, const SoundSettings& was) {
  const auto refuse = [&](const std::string& key, const char* why) {
    throw InputError(fmt::format("{}: {}: {} needs a new start", show.file.string(), key, why));
  };
  if (!sounded) {
    for (std::size_t i = 0; i < show.cues.size(); ++i) {
      if (!show.cues[i].sound.empty()) {
        refuse(fmt::format("cue.{}.sound", i), "sound in a show that began without any");
      }
    }
    return;  // nothing was opened
  }
  if (show.sound.device != was.device) refuse("sound.device", "another device");
  if (show.sound.channels != was.channels) refuse("sound.channels", "another number");
  if (show.sound.master != was.master) refuse("sound.master", "another master");
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

ShowReload::~ShowReload() {
  side_.reset();
  const std::unique_ptr<SoundSet> untaken(sounds_.take());
  const std::unique_ptr<SoundSet> left(sounds_.returned());
}

void ShowReload::ask() noexcept {
  asked_.store(true);
  side_->ring();
}

void ShowReload::taken(ReadyShow* ready) noexcept {
  handover_.give_back(ready);
  side_->ring();
}

void ShowReload::sounds_left(std::unique_ptr<SoundSet> old) noexcept {
  sounds_.give_back(old.release());
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
  if (current_->begun) current_->begun();
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
    if (const std::unique_ptr<SoundSet> left{sounds_.returned()}) old_is_heard_ = false;
    // What is not taken yet, or not left, rings when it is.
    if (fresh_ || old_is_heard_ || !asked_.exchange(false)) return;
    std::unique_ptr<ReadyShow> ready = open_ready();
    std::unique_ptr<SoundSet> sounds;
    if (ready->open_sounds) {
      apart([&] { sounds = ready->open_sounds(place_in(*ready)); });
      sounds->show = ready->number;
    }
    fresh_ = std::move(ready);
    old_is_heard_ = sounds != nullptr;
    if (sounds) sounds_.offer(sounds.release());  // first: it is there when the loop plays its show
    handover_.offer(fresh_.get());
  } catch (const std::exception& error) {
    refuse(error.what());
  }
}

// On threads of their own, as a thread's priority can be lowered, but not raised again.
std::unique_ptr<ReadyShow> ShowReload::open_ready() {
  auto ready = std::make_unique<ReadyShow>();
  ready->number = current_->number + 1;
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
  const Timeline::Place place = place_in(ready);
  const std::array<PlayerCommand, 2> there = {PlayerCommand{PlayerAction::kCue, {}, place.cue},
                                              PlayerCommand{PlayerAction::kSeek, place.position}};
  FrameMaker::Change change = ready.maker->advance({nanoseconds(0), nanoseconds(0), there});
  MonotonicClock clock;
  for (const auto until = clock.now() + kPatience;
       change == FrameMaker::Change::kUnchanged && clock.now() < until;) {
    clock.sleep_until(clock.now() + 1ms);
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

// Where the loop would go on now, as far as is known.
Timeline::Place ShowReload::place_in(const ReadyShow& ready) const {
  const PlayerStatus now = status_.read();
  if (now.show_number != current_->number) return {};  // the loop has not said so yet
  const std::optional<std::size_t> cue = ready.places[now.show.cue];
  return cue ? Timeline::Place{*cue, now.show.position} : Timeline::Place();
}

ShowReload::Open reopen_show(const Show& now, std::string file, std::vector<std::string> overrides,
                             std::string rig, std::string display, Cpu cpu, const TableCache& cache,
                             std::optional<SoundMode> sound, PatternBoard* patterns) {
  return [size = now.rig.frame.size, live = now.live(), sounds = now.sounds(), was = now.sound, sound,
          patterns, projector = now.devices.projector, file = std::move(file),
          overrides = std::move(overrides), rig = std::move(rig), display = std::move(display), cpu,
          cache = cache](ReadyShow& ready, bool for_good) mutable {
    const Show show = load_show(file, overrides, rig);
    if (live || show.live()) {
      throw InputError(fmt::format("{}: a show with live cues needs a new start", show.file.string()));
    }
    expect_same_sound(show, sounds, was);
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
    auto frames = std::make_unique<ShowFrames>(show, Method::kEwa, cpu, *ready.pool, false, &cache, decoding);
    if (sound) {
      ready.open_sounds = [show, timeline = frames->timeline(), mode = *sound](const Timeline::Place& place) {
        std::unique_ptr<SoundSet> set = open_sounds(show, timeline, mode);
        if (SoundAhead* const ahead = set->sounds[place.cue].ahead.get()) {
          ahead->read(std::llround(1e-9 * static_cast<double>(place.position.count()) * mode.rate), {});
        }
        return set;
      };
    }
    if (patterns) {
      ready.begun = [patterns, draw = pattern_drawer(show, cpu, cache)] { patterns->draw_by(draw); };
    }
    ready.maker = std::move(frames);
    ready.facts = facts_of(show, display);
    return decoders && !for_good;
  };
}

}  // namespace cupola
