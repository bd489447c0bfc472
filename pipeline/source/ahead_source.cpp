// One thread decodes, another one shows; between them a ring of frames and three counters.
// SPDX-License-Identifier: MIT
#include "pipeline/source/ahead_source.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cstdio>
#include <exception>
#include <utility>

#include "hal/time/clock.h"
#include "pipeline/source/face_changes.h"

namespace cupola {

AheadSource::AheadSource(FaceStreams faces, std::int64_t first, std::int64_t count, bool in_step)
    : faces_(std::move(faces)),
      first_(first),
      count_(count),
      in_step_(in_step),
      format_(faces_.format()),
      length_(faces_.length()),
      streams_(faces_.streams.size()),
      queue_(kAhead) {
  assert(length_ && first >= 0 && count > 0 && first + count <= *length_);
}

AheadSource::~AheadSource() {
  stopping_.store(true);
  bell_.fetch_add(1);
  bell_.notify_one();
  if (decoder_.joinable()) decoder_.join();
}

void AheadSource::prepare(std::span<const NeededRegion> needed) {
  assert(!decoder_.joinable());
  needed_.assign(needed.begin(), needed.end());
  const std::vector<RowRange> rows = faces_.needed_rows(needed);
  for (std::size_t s = 0; s < streams_.size(); ++s) {
    PictureStream& pictures = *faces_.streams[s];
    Stream& stream = streams_[s];
    stream.rows = rows[s];
    const bool moves = pictures.length() && !stream.rows.empty();
    // In use at once: those of the frames queued but one, whose slot is being filled; the one lent; the one
    // being decoded. The newest is queued or, when nothing is, one of three.
    for (int i = 0; i < (moves ? kAhead + 1 : 1); ++i) {
      stream.images.emplace_back(format_, pictures.size());
      counts_.bytes_ahead += static_cast<std::int64_t>(stream.images.back().bytes());
    }
    if (!pictures.length() && !stream.rows.empty())
      pictures.read(0, stream.rows, stream.images[0].pixels(), false);
  }
  for (const FacePlace& place : faces_.places) changed_.emplace_back(place.size);
  told_ = changed_;
  good_.resize(streams_.size());
  for (Frame& frame : queue_) {
    frame.images.resize(streams_.size());
    frame.changed = changed_;
  }
  decoder_ = std::thread([this] { decode_ahead(); });
  produced_.wait(0);
}

void AheadSource::decode_ahead() noexcept {
  std::int64_t next = 0;
  for (std::int64_t produced = 0;;) {
    const int bell = bell_.load();
    if (stopping_.load()) return;
    if (produced - consumed_.load() == kAhead) {
      bell_.wait(bell);
      continue;
    }
    next = std::max(next, asked_.load());
    decode(next++, slot(produced));
    produced_.store(++produced);
    produced_.notify_one();
  }
}

void AheadSource::decode(std::int64_t position, Frame& frame) noexcept {
  MonotonicClock clock;
  const std::chrono::nanoseconds begun = clock.now();
  frame.position = position;
  frame.failed = false;
  try {
    read_streams(position, frame);
    compare(frame);
    for (std::size_t s = 0; s < streams_.size(); ++s) streams_[s].newest = frame.images[s];
    any_good_ = whole_ = true;
  } catch (const std::exception& error) {
    whole_ = false;
    frame.failed = true;
    std::snprintf(frame.trouble.data(), frame.trouble.size(), "%s", error.what());
  }
  const std::int64_t took = (clock.now() - begun).count();
  decode_ns_ += took;
  ++decoded_;
  if (took > longest_ns_) longest_ns_ = took;
}

void AheadSource::read_streams(std::int64_t position, Frame& frame) {
  std::int64_t repeated = 0;
  for (std::size_t s = 0; s < streams_.size(); ++s) {
    Stream& stream = streams_[s];
    frame.images[s] = stream.newest;
    if (stream.images.size() == 1) continue;
    const std::size_t image = free_image(s);
    const bool read = faces_.streams[s]->read(frame_at(position), stream.rows, stream.images[image].pixels(),
                                              whole_ && any_good_);
    if (read) {
      frame.images[s] = image;
    } else {
      ++repeated;
    }
  }
  repeated_ += repeated;
}

std::size_t AheadSource::free_image(std::size_t s) const {
  const Stream& stream = streams_[s];
  // `held` after `consumed_`: what is lent meanwhile is still counted as queued.
  const std::int64_t consumed = consumed_.load();
  const std::int64_t produced = produced_.load();
  const std::size_t held = stream.held.load();
  for (std::size_t image = 0; image < stream.images.size(); ++image) {
    bool used = image == held || (any_good_ && image == stream.newest);
    for (std::int64_t i = consumed; i < produced && !used; ++i) {
      const Frame& queued = queue_[static_cast<std::size_t>(i) % queue_.size()];
      used = !queued.failed && queued.images[s] == image;
    }
    if (!used) return image;
  }
  assert(false);
  return 0;
}

void AheadSource::compare(Frame& frame) const {
  frame.changes_known = any_good_;
  for (std::size_t i = 0; i < frame.changed.size(); ++i) {
    frame.changed[i].clear();
    const FacePlace& place = faces_.places[i];
    const Stream& stream = streams_[place.stream];
    const std::size_t image = frame.images[place.stream];
    if (!any_good_ || image == stream.newest) continue;
    add_changes(part_of(stream.images[stream.newest].pixels(), place.x, place.y, place.size),
                part_of(stream.images[image].pixels(), place.x, place.y, place.size), needed_[i],
                frame.changed[i]);
  }
}

void AheadSource::ask(std::int64_t position) noexcept {
  asked_.store(position);
  bell_.fetch_add(1);
  bell_.notify_one();
}

void AheadSource::take(const Frame& frame) noexcept {
  taken_ = frame.position;
  taken_failed_ = frame.failed;
  if (frame.failed) {
    trouble_ = frame.trouble;
    return;
  }
  changes_known_ = changes_known_ && frame.changes_known;
  for (std::size_t i = 0; i < changed_.size(); ++i) changed_[i].add(frame.changed[i]);
  if (frame.position < floor_) return;
  has_good_ = true;
  good_position_ = frame.position;
  std::copy(frame.images.begin(), frame.images.end(), good_.begin());
}

void AheadSource::lend(FaceSet& faces) const noexcept {
  faces.faces.resize(faces_.places.size());
  faces.frame = frame_at(std::max<std::int64_t>(shown_, 0));
  for (std::size_t i = 0; i < faces_.places.size(); ++i) {
    const FacePlace& place = faces_.places[i];
    const Stream& stream = streams_[place.stream];
    faces.faces[i] = part_of(stream.images[stream.held.load()].pixels(), place.x, place.y, place.size);
  }
}

Fetch AheadSource::show(FaceSet& faces) noexcept {
  for (std::size_t s = 0; s < streams_.size(); ++s) streams_[s].held.store(good_[s]);
  shown_ = good_position_;
  lend(faces);
  std::swap(changed_, told_);
  for (ChangedCells& changed : changed_) changed.clear();
  if (std::exchange(changes_known_, true)) faces.changed = told_;
  const auto stands = [](const ChangedCells& changed) { return changed.count() == 0; };
  return std::ranges::all_of(faces.changed, stands) && !faces.changed.empty() ? Fetch::kUnchanged
                                                                              : Fetch::kNew;
}

void AheadSource::count_missing(std::int64_t position) noexcept {
  if (std::exchange(counted_, position) == position) return;
  ++(shown_ < floor_ ? counts_.sought : counts_.late);
}

Fetch AheadSource::fetch(std::int64_t frame, FaceSet& faces) noexcept {
  faces.changed = {};
  if (faces.faces.empty()) lend(faces);
  if (frame < first_ || frame >= first_ + count_) return Fetch::kEnd;
  const std::int64_t asked = asked_.load();
  const std::int64_t step = ((frame - frame_at(asked)) % count_ + count_) % count_;
  const std::int64_t position = asked + step;
  if (step > kAhead) floor_ = position;
  if (taken_ >= position) {  // it was asked for before
    if (taken_failed_) return Fetch::kFailed;
    lend(faces);
    return Fetch::kUnchanged;
  }
  has_good_ = false;
  for (;;) {
    std::int64_t consumed = consumed_.load();
    const std::int64_t produced = produced_.load();
    while (consumed < produced && slot(consumed).position <= position) take(slot(consumed++));
    const bool there = taken_ == position;
    if (there && taken_failed_) has_good_ = false;
    if (!there && in_step_) has_good_ = false;
    Fetch result = Fetch::kNotYet;
    if (has_good_) result = show(faces);  // before others may use its images
    consumed_.store(consumed);
    ask(position);
    if (there && taken_failed_) {
      ++counts_.broken;
      return Fetch::kFailed;
    }
    if (there) return result;
    if (!in_step_) {
      count_missing(position);
      return result;
    }
    produced_.wait(produced);
  }
}

void AheadSource::rest() noexcept {
  const std::int64_t asked = asked_.load();
  const std::int64_t position = asked + (count_ - asked % count_) % count_;
  if (position == asked) return;
  floor_ = position;
  std::int64_t consumed = consumed_.load();
  const std::int64_t produced = produced_.load();
  while (consumed < produced && slot(consumed).position < position) take(slot(consumed++));
  consumed_.store(consumed);
  ask(position);
}

FileCounts AheadSource::counts() const noexcept {
  FileCounts counts = counts_;
  counts.repeated = repeated_.load();
  counts.decoded = decoded_.load();
  counts.decode_ns = decode_ns_.load();
  counts.longest_ns = longest_ns_.load();
  return counts;
}

}  // namespace cupola
