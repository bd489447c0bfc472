// A frame's turn: wait for the flip before, see that a screen is there, hand over, wait for the flip.
// SPDX-License-Identifier: MIT
#include "hal/display/kms_display.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <xf86drm.h>
#include <xf86drmMode.h>

#include "hal/display/flip_time.h"
#include "hal/display/kms_commit.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

using namespace std::chrono_literals;

// A flip that takes longer than this many periods is taken for a screen that is away.
constexpr int kPatience = 3;
// One that takes longer than this is taken for one whose announcement was lost.
constexpr nanoseconds kStuck = 1s;
constexpr std::size_t kMostModes = 256;

bool card_is_gone(int error) {
  return error == ENODEV || error == ENXIO || error == EBADF || error == ENOTTY;
}

}  // namespace

KmsDisplay::KmsDisplay(Clock& clock, const KmsSettings& settings, int width, int height)
    : clock_(clock), width_(width), height_(height), wish_(settings.mode) {
  if (width < 1 || height < 1 || width > 65535 || height > 65535) {
    throw std::runtime_error("kms: expected frames with sides from 1 to 65535");
  }
  open(settings);
  last_flip_ = clock_.now();
}

KmsDisplay::~KmsDisplay() {
  wait_for_flip(clock_.now() + kPatience * period_);
  if (on_) commit_off(card_, pipe_);
  for (KmsBuffer& each : buffers_) memory_->free(each);
  for (KmsBuffer& each : nv12_buffers_) memory_->free(each);
  if (mode_blob_ != 0) drmModeDestroyPropertyBlob(card_.get(), mode_blob_);
}

void KmsDisplay::open(const KmsSettings& settings) {
  std::string seen;
  for (const KmsCard& card : list_kms_cards()) {
    if (!settings.card.empty() && card.path != settings.card) continue;
    const auto found = choose_kms_connector(card.connectors, settings.connector);
    if (found) {
      const KmsConnector& connector = card.connectors[*found];
      card_ = open_kms_card(card.path);
      pipe_ = find_kms_pipe(card_, connector);
      plug_ = std::make_unique<KmsPlug>(card.path, connector.name);
      memory_ = settings.memory == KmsMemoryKind::kGbm ? gbm_memory(card_.get()) : dumb_memory(card_.get());
      connector_ = connector.name;
      description_ = connector.name + " on " + card.path.string();
      return start(connector);
    }
    seen += seen.empty() ? "; " : ", ";
    seen += card.path.string() + " has";
    for (const KmsConnector& connector : card.connectors) {
      seen += " " + connector.name + (connector.connected ? "" : " (nothing plugged in)");
    }
    if (!card.trouble.empty()) seen += " trouble: " + card.trouble;
  }
  if (seen.empty()) throw std::runtime_error("kms: there is no card in /dev/dri");
  throw std::runtime_error("kms: no connector " +
                           (settings.connector.empty() ? "has a projector" : settings.connector) + seen);
}

void KmsDisplay::start(const KmsConnector& connector) {
  const auto refuse = [&](const std::string& why) {
    for (KmsBuffer& each : buffers_) memory_->free(each);
    throw std::runtime_error("kms: " + why);
  };
  if (!connector.connected) {
    // Something to draw into until there is a mode.
    if (const int error = make_buffers(width_, height_)) refuse(connector_ + ": " + std::strerror(error));
    return;
  }
  const KmsModeChoice choice = choose_kms_mode(connector.modes, wish_, width_, height_);
  if (choice.trouble != KmsModeTrouble::kNone) refuse(describe(choice, connector, wish_, width_, height_));
  const KmsMode& mode = connector.modes[choice.index];
  description_ = connector_ + " at " + name_of(mode) + description_.substr(connector_.size());
  if (const int error = make_buffers(mode.width, mode.height)) {
    refuse(connector_ + ": buffers of " + name_of(mode) + ": " + std::strerror(error));
  }
  // Black, so that what fails fails now.
  turns_.presented();
  if (!find_mode()) refuse(trouble());
  int error = hand_over();
  // Whoever had the screen before may still be letting go of it.
  for (const nanoseconds deadline = clock_.now() + 1s; error == EBUSY && clock_.now() < deadline;) {
    clock_.sleep_until(clock_.now() + 1ms);
    error = hand_over();
  }
  if (error == EACCES || error == EPERM) refuse(connector_ + ": another program has the screen");
  if (error != 0) refuse(connector_ + ": " + name_of(mode) + ": " + std::strerror(error));
  if (!wait_for_flip(clock_.now() + 5s)) refuse(connector_ + ": " + name_of(mode) + ": it never flips");
  turns_.forget();
}

bool KmsDisplay::prepare_nv12(ScanoutColour colour) {
  if (!choose_nv12(card_, pipe_, colour)) return false;
  nv12_black_ = colour.full_range ? 0 : 16;
  int error = 0;
  for (KmsBuffer& each : nv12_buffers_) {
    if (error == 0) error = make(each, true, buffers_[0].width, buffers_[0].height);
  }
  if (error == 0 && on_) error = test_flip(card_, pipe_, nv12_buffers_[0]);
  nv12_able_ = error == 0;
  if (error != 0)
    std::for_each(nv12_buffers_.begin(), nv12_buffers_.end(), [&](auto& each) { memory_->free(each); });
  return nv12_able_;
}

KmsBuffer& KmsDisplay::buffer(int turn) noexcept {
  const auto index = static_cast<std::size_t>(turn);
  return is_nv12_[index] ? nv12_buffers_[index] : buffers_[index];
}

DisplayBuffer KmsDisplay::frame_in(const KmsBuffer& of) const {
  const std::ptrdiff_t left = (of.width - width_) / 4 * 2;  // pixels; with chroma for every other one
  const std::ptrdiff_t top = (of.height - height_) / 4 * 2;
  if (!of.chroma) return {of.data + top * of.stride + 4 * left, of.stride, width_, height_};
  return {of.data + top * of.stride + left,      of.stride, width_, height_, 0,
          of.chroma + top / 2 * of.stride + left};
}

void KmsDisplay::copy_frame(const KmsBuffer& from, const KmsBuffer& to) const noexcept {
  const DisplayBuffer old = frame_in(from);
  const DisplayBuffer now = frame_in(to);
  const auto copy = [&](const std::byte* source, std::byte* target, int rows, int bytes) {
    for (int y = 0; y < rows; ++y) {
      std::memcpy(target + y * now.stride, source + y * old.stride, static_cast<std::size_t>(bytes));
    }
  };
  copy(old.data, now.data, height_, old.chroma ? width_ : 4 * width_);
  if (old.chroma) copy(old.chroma, now.chroma, (height_ + 1) / 2, (width_ + 1) / 2 * 2);
}

int KmsDisplay::make(KmsBuffer& buffer, bool nv12, int width, int height) noexcept {
  return nv12 ? memory_->make_nv12(buffer, width, height, nv12_black_) : memory_->make(buffer, width, height);
}

int KmsDisplay::make_buffers(int width, int height) noexcept {
  for (KmsBuffer& each : buffers_) {
    if (const int error = memory_->make(each, width, height)) return error;
  }
  return 0;
}

// Keeps the frame that was presented last.
int KmsDisplay::resize_buffers(int width, int height) noexcept {
  if (buffers_[0].width == width && buffers_[0].height == height) return 0;
  const bool nv12 = turns_.last() >= 0 && buffer(turns_.last()).chroma;
  KmsBuffer larger;
  if (const int error = make(larger, nv12, width, height)) return error;
  if (turns_.last() >= 0) {
    KmsBuffer& last = buffer(turns_.last());
    if (memory_->open(last) == 0 && memory_->open(larger) == 0) copy_frame(last, larger);
    memory_->close(larger);
  }
  is_nv12_ = {nv12};
  memory_->free(buffer(0));
  buffer(0) = larger;
  turns_.replaced();
  for (KmsBuffer& each : buffers_) {
    if (&each == &buffer(0)) continue;
    if (const int error = make(each, false, width, height)) return error;
  }
  for (KmsBuffer& each : nv12_buffers_) {
    if (!nv12_able_ || &each == &buffer(0)) continue;
    if (const int error = make(each, true, width, height)) return error;
  }
  return 0;
}

// Asks the projector what it can do, which may take as long as reading its description does, and takes the
// mode.
bool KmsDisplay::find_mode() noexcept {
  drmModeConnector* connector = drmModeGetConnector(card_.get(), pipe_.connector);
  if (!connector) return fail(errno, "reading its modes");
  std::array<KmsMode, kMostModes> modes;
  const int count = std::min(connector->count_modes, static_cast<int>(kMostModes));
  for (int i = 0; i < count; ++i) modes[static_cast<std::size_t>(i)] = mode_of(*connector, i);
  const KmsModeChoice choice =
      choose_kms_mode({modes.data(), static_cast<std::size_t>(count)}, wish_, width_, height_);
  const KmsMode& mode = modes[choice.index];
  std::uint32_t blob = 0;
  int error = 0;
  if (choice.trouble == KmsModeTrouble::kNone) {
    error = -drmModeCreatePropertyBlob(card_.get(), &connector->modes[choice.index], sizeof(drmModeModeInfo),
                                       &blob);
  }
  drmModeFreeConnector(connector);
  switch (choice.trouble) {
    case KmsModeTrouble::kNone:
      break;
    case KmsModeTrouble::kNoModes:
      return fail("has no modes");
    case KmsModeTrouble::kNoSuchMode:
      return fail("has come back without the mode");
    case KmsModeTrouble::kFrameLarger:
      return fail("has come back with a mode that is too small for the frame");
  }
  if (error != 0) return fail(error, "keeping its mode");
  if (mode_blob_ != 0) drmModeDestroyPropertyBlob(card_.get(), mode_blob_);
  mode_blob_ = blob;
  period_ = mode.period;
  if (const int no_memory = resize_buffers(mode.width, mode.height)) return fail(no_memory, "new buffers");
  return mode_known_ = true;
}

// The frame presented last, to a screen that shows ours already or with the mode.
int KmsDisplay::hand_over() noexcept {
  KmsBuffer& last = buffer(turns_.last());
  const int error = on_ ? commit_flip(card_, pipe_, last, flips_ + 1)
                        : commit_mode(card_, pipe_, mode_blob_, last, flips_ + 1);
  if (error != 0) return error;
  ++flips_;
  handed_over_ = clock_.now();
  on_ = true;
  turns_.committed();
  return 0;
}

// So that the mode is set anew when the screen is back. Refused while a flip is on its way: then the next
// time.
void KmsDisplay::switch_off() noexcept {
  mode_known_ = false;
  if (!on_ || turns_.in_flight()) return;
  if (commit_off(card_, pipe_) != 0) return;
  on_ = false;
  turns_.switched_off();
}

// True when nothing is on its way any more.
bool KmsDisplay::wait_for_flip(nanoseconds deadline) noexcept {
  const int descriptor = card_.get();
  while (turns_.in_flight()) {
    const bool ready = clock_.wait({&descriptor, 1}, deadline);
    if (take_flip(card_, flips_, last_flip_)) {
      turns_.flipped();
    } else if (!ready || clock_.now() >= deadline) {
      break;
    } else {
      clock_.sleep_until(std::min(deadline, clock_.now() + 1ms));  // something else, or an error that stays
    }
  }
  return !turns_.in_flight();
}

bool KmsDisplay::fail(const char* why) noexcept {
  std::snprintf(trouble_.data(), trouble_.size(), "%s %s", connector_.c_str(), why);
  return false;
}

bool KmsDisplay::fail(int error, const char* step) noexcept {
  std::snprintf(trouble_.data(), trouble_.size(), "%s: %s: %s", connector_.c_str(), step,
                strerrordesc_np(error));
  gone_ = gone_ || card_is_gone(error);
  return false;
}

// Brings the frame presented last to the screen at `flip`, or says why not.
bool KmsDisplay::show_last(nanoseconds flip) noexcept {
  // The kernel flips at the first chance after it was asked: so not before the flip ahead of ours is over.
  clock_.sleep_until(flip - period_ * 3 / 4);
  if (!wait_for_flip(flip)) {
    if (clock_.now() < handed_over_ + kStuck) return fail("does not flip");
    on_ = false;
    turns_.switched_off();
  }
  if (!plug_->in()) {
    switch_off();
    next_search_ = nanoseconds(0);
    return fail("has nothing plugged in");
  }
  if (on_ && !mode_known_) switch_off();
  if (on_ && !mode_known_) return fail("is still being switched off");
  const char* step = on_ ? "flip" : "setting its mode";
  if (!on_ && !mode_known_) {
    if (clock_.now() < next_search_) return false;
    next_search_ = clock_.now() + 1s;
    if (!find_mode()) return false;
  }
  int error = hand_over();
  if (error == EACCES || error == EPERM) {
    // Somebody else drew and may have left any mode behind.
    on_ = false;
    turns_.switched_off();
    if (drmSetMaster(card_.get()) == 0) error = hand_over();
    if (error == EACCES || error == EPERM) return fail("belongs to another program for now");
  }
  if (error != 0) {
    if (error != EBUSY) switch_off();
    return fail(error, step);
  }
  if (!wait_for_flip(std::max(flip, clock_.now()) + kPatience * period_)) return fail("does not flip");
  return true;
}

// What the turn's buffer of the other format held is forgotten.
DisplayBuffer KmsDisplay::back(bool nv12) noexcept {
  const bool held = std::exchange(is_nv12_[static_cast<std::size_t>(turns_.back())], nv12) == nv12;
  KmsBuffer& back = buffer(turns_.back());
  if (const int error = memory_->open(back)) {
    fail(error, "opening a buffer");
    return {nullptr, 0, width_, height_};
  }
  DisplayBuffer frame = frame_in(back);
  frame.age = held ? turns_.age() : 0;
  return frame;
}

Presented KmsDisplay::present(nanoseconds when) noexcept {
  memory_->close(buffer(turns_.back()));
  turns_.presented();
  return repeat(when);
}

Presented KmsDisplay::repeat(nanoseconds when) noexcept {
  assert(turns_.last() >= 0);
  if (gone_) return {Present::kLost, clock_.now()};
  const nanoseconds flip = next_flip(last_flip_, period_, when, clock_.now());
  const bool shown = show_last(flip);
  if (gone_) return {Present::kLost, clock_.now()};
  if (!shown) last_flip_ = std::max(flip, last_flip_);
  clock_.sleep_until(last_flip_);
  return {shown ? Present::kShown : Present::kAway, last_flip_};
}

}  // namespace cupola
