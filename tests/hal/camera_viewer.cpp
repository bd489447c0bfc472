// The loop that every user of a CameraWatch has.
// SPDX-License-Identifier: MIT
#include "tests/hal/camera_viewer.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include <gtest/gtest.h>

#include "hal/camera/camera_planes.h"
#include "hal/camera/fake_picture.h"
#include "tests/hal/heap_allocations.h"

namespace cupola {

using std::chrono::nanoseconds;

CameraViewer::CameraViewer(CameraStage& stage, const CameraStageMaker& maker)
    : stage_(stage),
      maker_(maker),
      watch_(stage.camera(), stage.setup(), stage.clock(), kPatience + maker.lateness) {}

CameraViewer::Seen CameraViewer::watch_until(nanoseconds end, bool one_frame) {
  Clock& clock = stage_.clock();
  Seen seen;
  do {
    for (bool more = true; more;) {
      CameraFrame frame;
      const std::uint64_t starts = watch_.counts().starts + watch_.counts().failed_starts;
      const std::uint64_t allocations = heap_allocations();
      const CameraWatch::Poll polled = watch_.poll(frame);
      if (watch_.counts().starts + watch_.counts().failed_starts == starts) {
        EXPECT_EQ(heap_allocations(), allocations) << "only a start may allocate";
      }
      switch (polled) {
        case CameraWatch::Poll::kFrame:
          check(frame);
          watch_.give_back(frame);
          seen.last_at = clock.now();
          if (seen.frames++ == 0) seen.first_at = seen.last_at;
          break;
        case CameraWatch::Poll::kLost:
          ++seen.losses;
          seen.lost_at = clock.now();
          break;
        case CameraWatch::Poll::kBack:
          ++seen.backs;
          stamp_offset_.reset();
          break;
        case CameraWatch::Poll::kNothing:
          more = false;
      }
    }
    const std::array<int, 1> descriptors = {watch_.descriptor()};
    if (one_frame && seen.frames > 0) break;
    clock.wait(descriptors, std::min(end, watch_.deadline()));
  } while (clock.now() < end);
  frames_ += seen.frames;
  return seen;
}

void CameraViewer::check(const CameraFrame& frame) {
  ASSERT_TRUE(fits(frame, watch_.mode()));
  ASSERT_TRUE(is_whole(frame));
  if (sequence_) {
    ASSERT_GT(frame.sequence, *sequence_);
  }
  sequence_ = frame.sequence;
  ASSERT_GT(frame.captured_at, captured_at_);
  ASSERT_LE(frame.captured_at, stage_.clock().now());
  ASSERT_GT(frame.captured_at, stage_.clock().now() - kPatience - maker_.lateness);
  captured_at_ = frame.captured_at;
  if (!maker_.stamped) return;
  const std::optional<PictureStamp> stamp = read_stamp(frame);
  ASSERT_TRUE(stamp);
  const std::uint32_t offset = stamp->sequence - static_cast<std::uint32_t>(frame.sequence);
  if (stamp_offset_) {
    ASSERT_EQ(offset, *stamp_offset_) << "another frame's picture";
  }
  stamp_offset_ = offset;
}

namespace {
std::uint64_t said = 0;
}  // namespace

void say_frames(const std::string& who, std::uint64_t frames) {
  said += frames;
  std::printf("%s: %llu frames\n", who.c_str(), static_cast<unsigned long long>(frames));
}

std::uint64_t frames_said() {
  return said;
}

}  // namespace cupola
