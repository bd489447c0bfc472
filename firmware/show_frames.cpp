// Opening all cues of a show, then stepping through them.
// SPDX-License-Identifier: MIT
#include "firmware/show_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string_view>
#include <tuple>

#include "firmware/finished_frames.h"
#include "firmware/frame_mix.h"
#include "firmware/held_budget.h"
#include "pipeline/frame/error.h"
#include "pipeline/source/ahead_source.h"
#include "pipeline/source/numbered_files.h"
#include "pipeline/warp/table_key.h"

namespace cupola {
namespace {

void add_fade(CueTiming& timing, const Cue& cue) {
  if (cue.fade_s <= 0.0) return;
  timing.fade_frames = std::max<std::int64_t>(1, std::llround(cue.fade_s * timing.rate));
  if (!cue.loop && !cue.duration_s && timing.frames && timing.fade_frames > *timing.frames) {
    throw InputError(fmt::format("cue {}: fade_s = {} is longer than the cue, {:.3g} s", cue.name, cue.fade_s,
                                 static_cast<double>(*timing.frames) / timing.rate));
  }
}

CueTiming timing_at(double rate, const Cue& cue) {
  CueTiming timing;
  timing.rate = rate;
  timing.loop = cue.loop;
  timing.then = cue.then;
  timing.wait = cue.wait;
  if (cue.duration_s) timing.duration = std::chrono::nanoseconds(std::llround(*cue.duration_s * 1e9));
  return timing;
}

CueTiming part_of_cue(const Cue& cue, const FaceSource& source) {
  CueTiming timing = timing_at(rate_of(cue, source), cue);
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

CueTiming timing_of(const Cue& cue, const FaceSource& source) {
  CueTiming timing = part_of_cue(cue, source);
  add_fade(timing, cue);
  return timing;
}

ShowFrames::ShowFrames(const Show& show, Method method, Cpu cpu, WorkerPool& pool, bool whole_faces,
                       TableCache* cache, Decoding decoding, std::unique_ptr<LiveFrames> live)
    : frame_size_(show.rig.frame.size), live_(std::move(live)), timeline_({CueTiming{}}), pool_(pool) {
  std::vector<CueTiming> timings;
  using Needs = std::tuple<std::vector<Size>, PixelFormat, std::optional<Method>, bool>;
  std::vector<Needs> kinds;  // of each warp: its faces' sizes and depth, the method beside it, finished
  for (const Cue& cue : show.cues) {
    OpenCue open;
    open.name = cue.name;
    if (cue.source == CueSource::kLive) {
      if (!live_) throw InputError(fmt::format("cue {}: live can only be played", cue.name));
      open.rig = live_->rig();
      timings.push_back(timing_at(live_->rate(), cue));
      add_fade(timings.back(), cue);
      cues_.push_back(std::move(open));
      continue;
    }
    open.rig = show.rig;
    open.source = open_source(cue, show.rig, pool);
    timings.push_back(timing_of(cue, *open.source));
    if (decoding != Decoding::kInTurn) open_ahead(open, timings.back(), decoding == Decoding::kAheadInStep);
    open.files = dynamic_cast<FileFaces*>(open.source.get());
    const std::vector<Size> faces = open.source->face_sizes();
    fit_faces(open.rig, cue, *open.source);
    const Needs needs{faces, open.source->format(), cue.compare, cue.finished};
    open.warp = static_cast<std::size_t>(std::find(kinds.begin(), kinds.end(), needs) - kinds.begin());
    if (open.warp == kinds.size()) {
      kinds.push_back(needs);
      if (!cue.finished)
        hold_budget(open.rig, open.source->format() == PixelFormat::kRgbPlanar16, cpu, pool, cache);
      warps_.push_back({cue.finished  ? make_finished_frames(frame_size_, pool)
                        : cue.compare ? make_split_warp(open.rig, *cue.compare, method, cpu, pool, cache)
                                      : make_frame_warp(open.rig, method, cpu, pool, cache),
                        ChangeHistory(faces),
                        {},
                        0});
      for (std::size_t i = 0; i < faces.size(); ++i) {
        CueWarp& made = warps_.back();
        made.even.emplace_back(faces[i]);
        made.texels_unneeded +=
            std::int64_t{faces[i].width} * faces[i].height - made.warp->needed()[i].texels();
      }
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
  rate_ = timings.front().rate;
  faces_.faces.reserve(show.rig.views.size());
  if (std::any_of(show.cues.begin(), show.cues.end(), [](const Cue& cue) { return cue.fade_s > 0.0; })) {
    old_faces_.faces.reserve(show.rig.views.size());
    take_fades(PixelFormat::kXrgb8888);
  }
  timeline_ = Timeline(std::move(timings));
}

// What moves in files is decoded ahead.
void ShowFrames::open_ahead(OpenCue& cue, const CueTiming& timing, bool in_step) const {
  auto* files = dynamic_cast<FileSource*>(cue.source.get());
  if (!files || !timing.frames) return;
  cue.source =
      std::make_unique<AheadSource>(std::move(*files).streams(), timing.first, *timing.frames, in_step);
}

PixelFormat ShowFrames::format() const {
  const bool deep = std::any_of(cues_.begin(), cues_.end(), [](const OpenCue& cue) {
    return cue.source && cue.source->format() == PixelFormat::kRgbPlanar16;
  });
  return deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
}

bool ShowFrames::begin_in(std::size_t cue, std::chrono::nanoseconds played) {
  Timeline timeline = timeline_;
  timeline.begin_in(cue, played);
  if (!timeline.at(std::chrono::nanoseconds(0))) return false;
  timeline_ = std::move(timeline);
  return true;
}

ShowFrames::Change ShowFrames::advance(const Due& due) noexcept {
  for (const PlayerCommand& command : due.commands) obey(timeline_, command, due.time);
  time_ = due.time;
  const std::optional<Moment> moment = timeline_.at(due.time);
  if (!moment) return Change::kOver;
  const Change change = advance_cues(*moment, timeline_.fade());
  return live_ ? advance_live(due, change) : change;
}

ShowFrames::Change ShowFrames::advance_cues(const Moment& moment, std::optional<Fade> fade) noexcept {
  if (fade && fade->from && is_live(fade->from->cue) && is_live(moment.cue)) fade.reset();  // one picture
  rest_unseen(moment, fade);
  const bool fetches = !asked_ || moment != moment_;
  if (!fetches && fade == fade_) return failed_ ? Change::kFailed : Change::kUnchanged;
  const bool goes_on = fade && fade_ && moment.cue == moment_.cue;
  old_stands_ = goes_on ? old_stands_ : fade && keep_mixed();
  if (fade && !old_stands_) fetch_old(*fade);
  fade_ = fade;
  moment_ = moment;
  const Fetch fetched = fetches ? fetch_new() : Fetch::kUnchanged;
  if (failed_) return Change::kFailed;
  if (fade_) {
    if (faces_cue_ == moment_.cue) {
      new_is_new_ = new_is_new_ || fetched == Fetch::kNew || new_frame_cue_ != moment_.cue;
      new_frame_cue_ = moment_.cue;
    }
    shown_cue_.reset();
    return Change::kNew;
  }
  new_frame_cue_.reset();
  if (fetched == Fetch::kNotYet) return Change::kUnchanged;
  const bool cut = shown_cue_ != moment_.cue;
  shown_cue_ = moment_.cue;
  if (fetched == Fetch::kUnchanged && !cut) return Change::kUnchanged;
  if (is_live(moment_.cue)) {
    live_->forget_frames();
  } else {
    note(warps_[cues_[moment_.cue].warp], cut ? std::span<const ChangedCells>() : faces_.changed);
  }
  return Change::kNew;
}

// Last, as the cameras are waited for until the warp has to begin.
ShowFrames::Change ShowFrames::advance_live(const Due& due, Change change) noexcept {
  const bool in_new = is_live(faces_cue_) && (!fade_ || faces_cue_ == moment_.cue);
  const bool in_old = fade_ && fade_->from && !old_stands_ && is_live(fade_->from->cue);
  live_is_seen_ = (in_new || in_old) && change != Change::kFailed;
  if (!live_is_seen_) {
    live_->advance_unseen();
    return change;
  }
  if (live_->advance(due) == Change::kUnchanged) return change;
  new_is_new_ = new_is_new_ || (fade_ && in_new);
  old_is_new_ = old_is_new_ || in_old;
  return Change::kNew;
}

void ShowFrames::shown(std::chrono::nanoseconds flipped_at) noexcept {
  if (live_is_seen_) live_->shown(flipped_at);
}

void ShowFrames::note(CueWarp& warp, std::span<const ChangedCells> changed) noexcept {
  warp.history.fetched(changed);
  for (std::size_t i = 0; i < warp.even.size(); ++i) {
    warp.even[i].look(faces_.faces[i], warp.warp->needed()[i], changed.empty() ? nullptr : &changed[i]);
  }
  texels_unneeded_ += warp.texels_unneeded;
}

// Files of cues that are not seen any more go back to their first frames.
void ShowFrames::rest_unseen(const Moment& moment, const std::optional<Fade>& fade) noexcept {
  const auto rest = [&](std::size_t cue) {
    const bool seen = cue == moment.cue || (fade && fade->from && fade->from->cue == cue);
    if (!seen && cues_[cue].files) cues_[cue].files->rest();
  };
  rest(moment_.cue);
  if (fade_ && fade_->from && fade_->from->cue != moment_.cue) rest(fade_->from->cue);
}

// Until the cue has any faces, those that were there stand; what is not there yet is asked for again.
Fetch ShowFrames::fetch_new() noexcept {
  const bool none = faces_.faces.empty();
  if (is_live(moment_.cue)) {
    faces_cue_ = moment_.cue;
    asked_ = true;
    failed_ = false;
    return Fetch::kUnchanged;
  }
  const Fetch fetched = cues_[moment_.cue].source->fetch(moment_.frame, faces_);
  failed_ = fetched == Fetch::kEnd || fetched == Fetch::kFailed;
  const bool got = fetched == Fetch::kNew || fetched == Fetch::kUnchanged;
  if (got || none) faces_cue_ = moment_.cue;
  asked_ = failed_ || (got && faces_.frame == moment_.frame);
  return fetched;
}

// Where there is none, or its source fails, the picture that it had stands.
void ShowFrames::fetch_old(const Fade& fade) noexcept {
  const bool begins =
      !fade_ || !fade_->from != !fade.from || (fade.from && fade.from->cue != fade_->from->cue);
  if (begins) old_faces_.faces.clear();  // another source's
  if (fade.from && !is_live(fade.from->cue) && (begins || fade.from != fade_->from)) {
    const Fetch fetched = cues_[fade.from->cue].source->fetch(fade.from->frame, old_faces_);
    old_is_new_ = old_is_new_ || fetched == Fetch::kNew;
    if (faces_cue_ == fade.from->cue) faces_ = old_faces_;  // the new cue has none yet
  }
  old_is_new_ = old_is_new_ || begins;
}

// Into the old frame, where a fade was seen: what comes next fades from there.
bool ShowFrames::keep_mixed() noexcept {
  if (!fade_ || old_is_new_ || new_is_new_) return false;
  if (new_frame_cue_ == moment_.cue)
    mix(as_const(old_frame_.pixels()), as_const(new_frame_.pixels()), fade_->weight, old_frame_.pixels(),
        pool_);
  new_frame_cue_.reset();
  return true;
}

void ShowFrames::take_fades(PixelFormat format) {
  old_frame_ = ImageBuffer(format, frame_size_);
  new_frame_ = ImageBuffer(format, frame_size_);
  old_is_new_ = new_is_new_ = true;
}

WarpWork ShowFrames::warp_fade(const MutableImage& frame) noexcept {
  if (frame.format != new_frame_.format()) take_fades(frame.format);
  WarpWork work;
  const std::chrono::nanoseconds begun = live_is_seen_ ? live_->clock().now() : std::chrono::nanoseconds(0);
  const auto make = [&](std::size_t cue, const FaceSet& faces, ImageBuffer& into) {
    if (is_live(cue)) {
      work += live_->warp(into.pixels(), 0);
      return;
    }
    work += warps_[cues_[cue].warp].warp->warp_known(faces.faces, {}, into.pixels());
  };
  const bool old_is_black = !fade_->from || old_stands_;  // what stood was of another format
  if (old_is_new_ && !old_is_black) make(fade_->from->cue, old_faces_, old_frame_);
  if (old_is_new_ && old_is_black) blacken(old_frame_.pixels());
  const bool has_new = new_frame_cue_ == moment_.cue;
  if (has_new && new_is_new_) make(moment_.cue, faces_, new_frame_);
  old_is_new_ = new_is_new_ = false;
  mix(as_const(old_frame_.pixels()), as_const(new_frame_.pixels()), has_new ? fade_->weight : 0, frame,
      pool_);
  warped_with_.reset();  // whatever comes next has nothing in common with it
  if (live_is_seen_) live_->note_warp_since(begun);
  return work;
}

WarpWork ShowFrames::warp(const MutableImage& frame, int age) noexcept {
  if (fade_) return warp_fade(frame);
  if (is_live(faces_cue_)) {
    warped_with_.reset();
    return live_->warp(frame, age);
  }
  const std::size_t index = cues_[faces_cue_].warp;
  CueWarp& by = warps_[index];
  // Frames of another warp lie between the buffer's and the last one in the history.
  if (warped_with_ != index) by.history.fetched({});
  warped_with_ = index;
  return by.warp->warp_known(faces_.faces, {by.history.take(age), by.even}, frame);
}

std::optional<YuvColour> ShowFrames::nv12_colour() const noexcept {
  return live_ ? live_->nv12_colour() : std::nullopt;
}

bool ShowFrames::gives_nv12() const noexcept {
  return !fade_ && is_live(faces_cue_) && live_->gives_nv12();
}

WarpWork ShowFrames::warp_nv12(const MutableNativeImage& frame, int age) noexcept {
  warped_with_.reset();
  return live_->warp_nv12(frame, age);
}

FacePicture ShowFrames::face(std::size_t view) const noexcept {
  if (is_live(faces_cue_)) return live_->face(view);
  return view < faces_.faces.size() ? FacePicture(faces_.faces[view]) : FacePicture();
}

std::vector<std::uint64_t> ShowFrames::key() const {
  std::vector<std::uint64_t> key;
  for (const OpenCue& cue : cues_) {
    const TableKey table = table_key(cue.rig);
    key.insert(key.end(), table.begin(), table.end());
    key.push_back((cue.rig.samples.linear_light ? 1U : 0U) + (cue.rig.samples.dither ? 2U : 0U));
    for (int i = 0; i < 9; ++i)
      key.push_back(std::bit_cast<std::uint64_t>(cue.rig.world_from_lens[i / 3][i % 3]));
    if (const auto* files = dynamic_cast<const FileSource*>(cue.source.get())) key.push_back(files->stamp());
  }
  return key;
}

FileCounts ShowFrames::file_counts() const noexcept {
  FileCounts sum;
  for (const OpenCue& cue : cues_) {
    if (cue.files) sum += cue.files->counts();
  }
  return sum;
}

void ShowFrames::report(ShowReport& report) const noexcept {
  report.cue = timeline_.cue();
  report.position = timeline_.position(time_);
  report.duration = timeline_.cue_length();
  report.waiting = timeline_.waiting();
  report.files = file_counts();
  const FileFaces* files = cues_[moment_.cue].files;
  if (live_) live_->report(report);
  report.queue = files ? files->queue() : FileQueue();
  char* end = report.trouble.data();
  if (failed_) end = format_trouble(report.trouble.data(), report.trouble.size() - 1);
  *end = '\0';
}

std::string ShowFrames::trouble() const {
  std::array<char, 1000> words{};
  return {words.data(), format_trouble(words.data(), words.size())};
}

char* ShowFrames::format_trouble(char* into, std::size_t most) const {
  const OpenCue& cue = cues_[moment_.cue];
  const std::string_view said = cue.files ? cue.files->trouble() : "";
  const std::string_view why = said.empty() ? std::string_view("the source has no such frame") : said;
  return fmt::format_to_n(into, most, "cue {}, frame {}: {}", cue.name, moment_.frame, why).out;
}

}  // namespace cupola
