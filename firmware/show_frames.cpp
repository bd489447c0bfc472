// Opening all cues of a show, then stepping through them.
// SPDX-License-Identifier: MIT
#include "firmware/show_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "pipeline/frame/error.h"
#include "pipeline/source/numbered_files.h"

namespace cupola {
namespace {

CueTiming timing(const Cue& cue, const FaceSource& source) {
  CueTiming timing;
  timing.rate = cue.rate;
  timing.loop = cue.loop;
  timing.then = cue.then;
  if (cue.duration_s) timing.duration = std::chrono::nanoseconds(std::llround(*cue.duration_s * 1e9));
  timing.frames = source.length();
  // Numbered files were cut to their part when they were opened.
  const bool cut =
      has_number(cue.file) || (cue.source == CueSource::kSequence && std::filesystem::is_directory(cue.file));
  if (cut || (!cue.part.in && !cue.part.out)) return timing;
  timing.first = cue.part.in.value_or(0);
  if (timing.frames && timing.first >= *timing.frames) {
    throw InputError(fmt::format("cue {}: in = {} is past the last frame, {}", cue.name, timing.first,
                                 *timing.frames - 1));
  }
  if (timing.frames && cue.part.out && *cue.part.out >= *timing.frames) {
    throw InputError(fmt::format("cue {}: out = {} is past the last frame, {}", cue.name, *cue.part.out,
                                 *timing.frames - 1));
  }
  if (cue.part.out) {
    timing.frames = *cue.part.out - timing.first + 1;
  } else if (timing.frames) {
    *timing.frames -= timing.first;
  }
  return timing;
}

}  // namespace

ShowFrames::ShowFrames(const Show& show, Method method, Cpu cpu, WorkerPool& pool, bool whole_faces,
                       TableCache* cache)
    : frame_size_(show.rig.frame.size), rate_(show.cues.front().rate), timeline_({CueTiming{}}) {
  if (show.live()) throw InputError(fmt::format("cue {}: live can only be played", show.cues.front().name));
  std::vector<CueTiming> timings;
  using Needs = std::tuple<std::vector<Size>, PixelFormat, std::optional<Method>>;
  std::vector<Needs> kinds;  // of each warp: its faces' sizes and depth, the method beside it
  for (const Cue& cue : show.cues) {
    OpenCue open;
    open.name = cue.name;
    open.rig = show.rig;
    open.source = open_source(cue, show.rig, pool);
    timings.push_back(timing(cue, *open.source));
    const std::vector<Size> faces = open.source->face_sizes();
    fit_faces(open.rig, cue, *open.source);
    const Needs needs{faces, open.source->format(), cue.compare};
    open.warp = static_cast<std::size_t>(std::find(kinds.begin(), kinds.end(), needs) - kinds.begin());
    if (open.warp == kinds.size()) {
      kinds.push_back(needs);
      warps_.push_back({cue.compare ? make_split_warp(open.rig, *cue.compare, method, cpu, pool, cache)
                                    : make_frame_warp(open.rig, method, cpu, pool, cache),
                        ChangeHistory(faces)});
    }
    if (whole_faces) {
      std::vector<NeededRegion> all;
      for (const Size size : faces) all.push_back(NeededRegion::all(size));
      open.source->prepare(all);
    } else {
      open.source->prepare(warps_[open.warp].warp->needed());
    }
    cues_.push_back(std::move(open));
  }
  faces_.faces.reserve(show.rig.views.size());
  timeline_ = Timeline(std::move(timings));
}

PixelFormat ShowFrames::format() const {
  const bool deep = std::any_of(cues_.begin(), cues_.end(), [](const OpenCue& cue) {
    return cue.source->format() == PixelFormat::kRgbPlanar16;
  });
  return deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
}

ShowFrames::Change ShowFrames::advance(const Due& due) noexcept {
  for (int i = 0; i < due.cues_on; ++i) timeline_.next_cue(due.time);
  const std::optional<Moment> moment = timeline_.at(due.time);
  if (!moment) return Change::kOver;
  if (asked_ && *moment == moment_) return failed_ ? Change::kFailed : Change::kUnchanged;
  moment_ = *moment;
  asked_ = true;
  const Fetch fetched = cues_[moment_.cue].source->fetch(moment_.frame, faces_);
  failed_ = fetched == Fetch::kEnd || fetched == Fetch::kFailed;
  if (failed_) return Change::kFailed;
  const bool cut = shown_cue_ != moment_.cue;
  shown_cue_ = moment_.cue;
  ChangeHistory& history = warps_[cues_[moment_.cue].warp].history;
  if (fetched == Fetch::kNew || cut) history.fetched(cut ? std::span<const ChangedCells>() : faces_.changed);
  return fetched == Fetch::kNew || cut ? Change::kNew : Change::kUnchanged;
}

WarpWork ShowFrames::warp(const MutableImage& frame, int age) noexcept {
  const std::size_t index = cues_[moment_.cue].warp;
  auto& [warp, history] = warps_[index];
  // Frames of another warp lie between the buffer's and the last one in the history.
  if (warped_with_ != index) history.fetched({});
  warped_with_ = index;
  return warp->warp_changed(faces_.faces, history.take(age), frame);
}

std::string ShowFrames::trouble() const {
  const OpenCue& cue = cues_[moment_.cue];
  const auto* files = dynamic_cast<const FileSource*>(cue.source.get());
  return fmt::format(
      "cue {}, frame {}: {}", cue.name, moment_.frame,
      files && !files->last_error().empty() ? files->last_error() : "the source has no such frame");
}

}  // namespace cupola
