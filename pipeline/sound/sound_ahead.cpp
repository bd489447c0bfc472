// One thread decodes into a ring, another one reads; neither holds the lock while it decodes.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/sound_ahead.h"

#include <algorithm>
#include <cassert>
#include <exception>

namespace cupola {

namespace {
constexpr std::int64_t kBlock = 2048;     // frames decoded at a time
constexpr std::int64_t kHistory = 32768;  // that were read and are kept: a pause goes on from a little before
}  // namespace

SoundAhead::SoundAhead(std::unique_ptr<SoundTrack> track, int channels, const SoundPart& part,
                       std::int64_t ahead, bool in_step)
    : track_(std::move(track)),
      channels_(static_cast<std::size_t>(channels)),
      part_(part),
      in_step_(in_step),
      room_(std::max(ahead, 2 * kBlock) + kHistory),
      ring_(static_cast<std::size_t>(room_) * channels_),
      block_(static_cast<std::size_t>(kBlock) * channels_) {
  assert(channels > 0 && part.first >= 0 && (!part.length || *part.length > 0));
  decoder_ = std::thread([this] { decode_ahead(); });
}

SoundAhead::~SoundAhead() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  rung_.notify_all();
  decoder_.join();
}

std::optional<std::int64_t> SoundAhead::ended() const noexcept {
  const std::lock_guard lock(mutex_);
  return ended_;
}

std::string SoundAhead::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

std::size_t SoundAhead::decode(std::int64_t place) noexcept {
  std::optional<std::int64_t> ended;
  {
    const std::lock_guard lock(mutex_);
    ended = ended_;
  }
  // The part's length is what was asked for; the sound in it may be shorter.
  const std::optional<std::int64_t> length = part_.length ? part_.length : ended;
  const std::int64_t within = part_.loop && length ? place % *length : place;
  std::int64_t most = kBlock;
  if (part_.loop && length) most = std::min(most, *length - within);
  std::int64_t sounds = most;
  if (part_.length) sounds = std::min(sounds, *part_.length - within);
  if (ended) sounds = std::min(sounds, *ended - within);
  if (sounds <= 0) {
    std::ranges::fill(block_, 0.0F);
    return static_cast<std::size_t>(most);
  }
  std::size_t read = 0;
  std::string trouble;
  try {
    read = track_->read(part_.first + within, {block_.data(), static_cast<std::size_t>(sounds) * channels_});
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  damaged_ = track_->damaged();
  if (read > 0) return read;
  {
    const std::lock_guard lock(mutex_);
    ended_ = std::clamp<std::int64_t>(within, 1, ended_.value_or(INT64_MAX));
    if (!trouble.empty()) trouble_ = trouble;
  }
  return 0;
}

void SoundAhead::decode_ahead() noexcept {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (end_ - begin_ > room_ - kBlock) {
      rung_.wait(lock);
      continue;
    }
    const std::int64_t place = end_;
    const std::int64_t jumps = jumps_;
    lock.unlock();
    const std::size_t made = decode(place);
    lock.lock();
    if (jumps != jumps_) continue;  // nobody wants it any more
    for (std::size_t i = 0; i < made; ++i) {
      const auto to = static_cast<std::size_t>((place + static_cast<std::int64_t>(i)) % room_);
      std::copy_n(block_.begin() + static_cast<std::ptrdiff_t>(i * channels_), channels_,
                  ring_.begin() + static_cast<std::ptrdiff_t>(to * channels_));
    }
    end_ += static_cast<std::int64_t>(made);
    filled_.notify_all();
  }
}

std::size_t SoundAhead::read(std::int64_t first, std::span<float> into) noexcept {
  const std::size_t wanted = into.size() / channels_;
  std::unique_lock lock(mutex_);
  if (first < begin_ || first - end_ > room_) {
    ++jumps_;
    begin_ = end_ = first;
  }
  next_ = first;  // beyond the end: what lies between is decoded and passed over
  begin_ = std::max(begin_, next_ - kHistory);
  std::size_t copied = 0;
  do {
    if (in_step_) {
      rung_.notify_all();
      filled_.wait(lock, [&] { return wanted == copied || end_ > next_; });
    }
    for (; copied < wanted && next_ < end_; ++copied, ++next_) {
      std::copy_n(
          ring_.begin() + static_cast<std::ptrdiff_t>(next_ % room_) * static_cast<std::ptrdiff_t>(channels_),
          channels_, into.begin() + static_cast<std::ptrdiff_t>(copied * channels_));
    }
  } while (in_step_ && copied < wanted);
  lock.unlock();
  rung_.notify_all();
  return copied;
}

}  // namespace cupola
