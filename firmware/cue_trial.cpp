// Frames are decoded as ahead of a show, by one thread, and warped as in it, whole.
// SPDX-License-Identifier: MIT
#include "firmware/cue_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "firmware/command.h"
#include "firmware/finished_frames.h"
#include "firmware/held_budget.h"
#include "firmware/show_frames.h"
#include "hal/time/clock.h"
#include "pipeline/frame/error.h"

namespace cupola {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kMostFaults = 20;  // a cue
constexpr int kMostTurns = 60;

double milliseconds(nanoseconds time) {
  return 1e-6 * static_cast<double>(time.count());
}

struct Times {
  double mean = 0.0;    // ms
  double median = 0.0;  // ms
};

// `turn` until `longest` is over, at least once; it gives false where there is nothing more to do.
template <class Turn>
Times measure(nanoseconds longest, const Turn& turn) {
  MonotonicClock clock;
  std::vector<double> times;
  const nanoseconds begun = clock.now();
  for (int i = 0; i < kMostTurns && (i == 0 || clock.now() - begun < longest); ++i) {
    const nanoseconds before = clock.now();
    if (!turn(i)) break;
    times.push_back(milliseconds(clock.now() - before));
  }
  if (times.empty()) return {};
  Times result;
  for (const double time : times) result.mean += time / static_cast<double>(times.size());
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
  result.median = times[times.size() / 2];
  return result;
}

std::string trouble_of(const FaceSource& source) {
  const auto* files = dynamic_cast<const FileFaces*>(&source);
  return files ? files->trouble() : "the faces cannot be made";
}

std::string length_of(const Cue& cue, const CueTiming& timing) {
  if (cue.duration_s) return fmt::format("{} s", *cue.duration_s);
  return timing.frames && !cue.loop ? grouped(*timing.frames) + " frames" : "endless";
}

double busiest_ms(const FrameCost& cost) {
  const double decode = cost.decode_ms.value_or(0.0);
  const double loop = cost.faces_ms + cost.warp_ms * (cost.fades ? 2.0 : 1.0) + decode / cost.threads;
  return std::max(decode, loop);
}

}  // namespace

double share_of_frame(const FrameCost& cost) {
  return busiest_ms(cost) * cost.rate / 1000.0;
}

std::string prediction(const FrameCost& cost) {
  std::string text = fmt::format("{:g} a second; ", cost.rate);
  if (cost.decode_ms) text += fmt::format("decode {:.1f} ms on one core ahead, ", *cost.decode_ms);
  if (cost.faces_ms >= 0.05) text += fmt::format("faces {:.1f} ms, ", cost.faces_ms);
  text += fmt::format("warp {:.1f} ms{}; ", cost.warp_ms, cost.fades ? ", twice in its fade" : "");
  const double share = share_of_frame(cost);
  if (holds(cost)) return text + fmt::format("holds ({:.0f} % of a frame's time)", 100.0 * share);
  const double most = 1000.0 / busiest_ms(cost);
  return text + fmt::format("does not hold: at most {:.{}f} a second", most, most < 10.0 ? 1 : 0);
}

CueTrials::CueTrials(const Rig& rig, Cpu cpu, WorkerPool& pool, TableCache* cache)
    : rig_(rig), cpu_(cpu), pool_(pool), one_(1), cache_(cache) {}

FrameWarp& CueTrials::warp_for(const Cue& cue, const FaceSource& source) {
  Rig rig = rig_;
  fit_faces(rig, cue, source);
  const Needs needs{source.face_sizes(), source.format(), cue.compare, cue.finished};
  const auto found =
      std::find_if(made_.begin(), made_.end(), [&](const Made& m) { return m.needs == needs; });
  if (found != made_.end()) return *found->warp;
  if (cue.finished) {
    made_.push_back({needs, make_finished_frames(rig.frame.size, pool_)});
  } else {
    hold_budget(rig, source.format() == PixelFormat::kRgbPlanar16, cpu_, pool_, cache_);
    made_.push_back({needs, cue.compare
                                ? make_split_warp(rig, *cue.compare, Method::kEwa, cpu_, pool_, cache_)
                                : make_frame_warp(rig, Method::kEwa, cpu_, pool_, cache_)});
  }
  return *made_.back().warp;
}

CueTrial CueTrials::run(const Cue& cue) {
  CueTrial trial;
  const bool made = cue.source == CueSource::kGenerated || cue.source == CueSource::kTestPattern;
  const std::unique_ptr<FaceSource> source = open_source(cue, rig_, made ? pool_ : one_);
  const CueTiming timing = timing_of(cue, *source);
  trial.length = length_of(cue, timing);
  if (const auto* files = dynamic_cast<const FileSource*>(source.get())) {
    trial.faults = files->faults();
    if (trial.faults.size() > kMostFaults) {
      const std::size_t more = trial.faults.size() - kMostFaults;
      trial.faults.resize(kMostFaults);
      trial.faults.push_back(fmt::format("{} more files are wrong", more));
    }
  }
  FrameWarp& warp = warp_for(cue, *source);
  source->prepare(warp.needed());
  FaceSet faces;
  const auto get = [&](std::int64_t frame) {
    const Fetch fetched = source->fetch(frame, faces);
    if (fetched == Fetch::kNew || fetched == Fetch::kUnchanged) return true;
    const std::string why = trouble_of(*source);
    if (std::find(trial.faults.begin(), trial.faults.end(), why) != trial.faults.end()) return false;
    trial.faults.push_back(fmt::format("frame {}: {}", frame, why.empty() ? "is not there" : why));
    return false;
  };
  // Of what never ends the last frame is any: that a second later.
  const std::int64_t first = timing.first;
  const std::int64_t last = timing.frames ? first + *timing.frames - 1 : first + 1;
  const bool ends = get(last);
  const bool begins = get(first);
  if (!trial.faults.empty() || !ends || !begins) return trial;

  FrameCost& cost = trial.cost;
  cost.rate = timing.rate;
  cost.threads = pool_.threads();
  cost.fades = cue.fade_s > 0.0;
  const auto next = [&](int turn) {
    const std::int64_t frame = first + 1 + turn;
    return (!timing.frames || frame <= last) && get(frame);
  };
  if (made) {
    cost.faces_ms = measure(700ms, next).median;
  } else if (timing.frames && *timing.frames > 1) {
    cost.decode_ms = measure(900ms, next).mean;  // those that take long are evened out by the queue
  }
  ImageBuffer frame(PixelFormat::kXrgb8888, rig_.frame.size);
  warp.warp(faces.faces, frame.pixels());  // its memory is touched
  cost.warp_ms = measure(500ms, [&](int) {
                   warp.warp(faces.faces, frame.pixels());
                   return true;
                 }).median;
  return trial;
}

}  // namespace cupola
