// Two rings of numbers: whoever has a chore's has what belongs to it.
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_chores.h"

#include <cerrno>
#include <system_error>

namespace cupola {

namespace {

constexpr int kStart = 0;
constexpr int kSet = 1;
constexpr int kEnd = 2;

}  // namespace

CameraChores::CameraChores(Camera& camera) : camera_(camera) {
  if (asked_.descriptor() < 0 || done_.descriptor() < 0) {
    throw std::system_error(EMFILE, std::generic_category(), "eventfd");
  }
  thread_ = std::thread([this] { work(); });
}

CameraChores::~CameraChores() {
  finish();
  asked_.push(kEnd);
  thread_.join();
}

void CameraChores::begin_start(const CameraSetup& setup) noexcept {
  setup_ = &setup;
  starting_ = true;
  asked_.push(kStart);
}

std::optional<CameraStart> CameraChores::take_start() noexcept {
  while (starting_) {
    const std::optional<int> chore = done_.pop();
    if (!chore) return std::nullopt;
    if (done(*chore)) return came_;
  }
  return std::nullopt;
}

void CameraChores::begin_controls(const Controls& controls) noexcept {
  controls_ = controls;
  setting_ = true;
  asked_.push(kSet);
}

bool CameraChores::setting() noexcept {
  if (const std::optional<int> chore = starting_ ? std::nullopt : done_.pop()) done(*chore);
  return setting_;
}

void CameraChores::finish() noexcept {
  while (starting_ || setting_) done(done_.wait());
}

// Whether it was the start.
bool CameraChores::done(int chore) noexcept {
  (chore == kStart ? starting_ : setting_) = false;
  return chore == kStart;
}

void CameraChores::work() noexcept {
  for (int chore = asked_.wait(); chore != kEnd; chore = asked_.wait()) {
    if (chore == kStart) {
      came_ = camera_.start(*setup_);
    } else {
      for (const CameraControl& control : controls_) {
        if (!control.name.empty()) camera_.set_control(control);
      }
    }
    done_.push(chore);
  }
}

}  // namespace cupola
