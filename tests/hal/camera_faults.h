// What becomes of a watched camera when its device fails. A program that has cameras includes this once and
// instantiates CameraFaults with camera_fault_cases() of their makers.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hal/camera_stage.h"
#include "tests/hal/camera_viewer.h"

namespace cupola {

class CameraFaults;

struct CameraFaultCase {
  const char* name;
  std::vector<CameraFault> needs;  // the stage's
  void (*run)(CameraFaults& test);
};

struct CameraFaultParam {
  CameraStageMaker maker;
  CameraFaultCase fault;
};
inline void PrintTo(const CameraFaultParam& param, std::ostream* out) {
  *out << param.maker.name << " " << param.fault.name;
}
inline std::string name_of_case(const testing::TestParamInfo<CameraFaultParam>& param) {
  return std::string(param.param.maker.name) + "_" + param.param.fault.name;
}

class CameraFaults : public testing::TestWithParam<CameraFaultParam> {
 public:
  using Seen = CameraViewer::Seen;

  ~CameraFaults() override { say_frames(GetParam().maker.name, viewer_.frames()); }

  const CameraStageMaker& maker() const { return GetParam().maker; }
  CameraStage& stage() { return *stage_; }
  CameraViewer& viewer() { return viewer_; }
  std::chrono::nanoseconds period() {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / stage_->setup().rate));
  }
  // That a machine which is busy otherwise may miss.
  double frames_late() {
    return stage_->setup().rate * std::chrono::duration<double>(maker().lateness).count();
  }
  std::chrono::nanoseconds patience() const { return CameraViewer::kPatience + maker().lateness; }
  const CameraCounts& counts() { return viewer_.watch().counts(); }

  // A second of frames as they should be.
  void expect_health(const char* when) {
    const CameraCounts before = counts();
    const Seen seen = viewer_.run(std::chrono::seconds(1));
    EXPECT_NEAR(static_cast<double>(seen.frames), stage_->setup().rate, 2.0 + frames_late()) << when;
    EXPECT_EQ(seen.losses, 0) << when;
    EXPECT_EQ(counts().damaged, before.damaged) << when;
    EXPECT_EQ(counts().clock_steps, before.clock_steps) << when;
    EXPECT_EQ(viewer_.watch().state(), CameraState::kStreaming) << when;
  }
  // A fault that frames get through: returns what was seen while it lasted.
  Seen endure(CameraFault fault, std::int64_t amount) {
    expect_health("before");
    stage_->begin_fault(fault, amount);
    const Seen seen = viewer_.run(maker().faults_last);
    EXPECT_EQ(seen.losses, 0);
    EXPECT_EQ(counts().losses, 0U);
    stage_->end_faults();
    viewer_.run(2 * period());
    expect_health("after");
    EXPECT_EQ(counts().starts, 1U);
    return seen;
  }
  // A fault that ends the stream: told in time, counted once, and over soon.
  void lose(CameraFault fault, std::int64_t amount, CameraCause cause) {
    expect_health("before");
    lose_briefly(fault, amount, cause, maker().faults_last);
    expect_health("after");
  }
  void lose_briefly(CameraFault fault, std::int64_t amount, CameraCause cause,
                    std::chrono::nanoseconds lasts) {
    const CameraCounts before = counts();
    const std::chrono::nanoseconds begun = stage_->clock().now();
    stage_->begin_fault(fault, amount);
    const Seen seen = viewer_.run(lasts);
    EXPECT_EQ(seen.losses, 1);
    EXPECT_LE(seen.lost_at - begun, patience() + period());
    EXPECT_EQ(viewer_.watch().state(), CameraState::kLost);
    EXPECT_EQ(viewer_.watch().trouble().cause, cause) << describe(viewer_.watch().trouble());
    EXPECT_EQ(counts().losses, before.losses + 1);
    EXPECT_EQ(counts().of(cause), before.of(cause) + 1);
    const std::uint64_t barks = cause == CameraCause::kSilent ? 1 : 0;
    EXPECT_EQ(counts().silences, before.silences + barks);
    recover();
  }
  void recover() {
    const CameraCounts before = counts();
    stage_->end_faults();
    const std::chrono::nanoseconds ended = stage_->clock().now();
    const Seen seen =
        viewer_.run_until_frame(2 * period() + maker().lateness + std::chrono::milliseconds(100));
    EXPECT_EQ(seen.backs, 1);
    EXPECT_GT(seen.frames, 0U);
    EXPECT_LE(seen.first_at - ended, 2 * period() + maker().lateness);
    EXPECT_EQ(counts().losses, before.losses);
  }
  // Unplugged, and another device comes back.
  void return_changed(CameraFault fault) {
    expect_health("before");
    stage_->begin_fault(CameraFault::kUnplugged, 0);
    EXPECT_EQ(viewer_.run(std::chrono::milliseconds(500)).losses, 1);
    stage_->end_faults();
    stage_->begin_fault(fault, 0);
    const Seen seen = viewer_.run(std::chrono::seconds(1));
    EXPECT_EQ(seen.frames, 0U);
    EXPECT_EQ(seen.losses, 0) << "it was told already";
    EXPECT_EQ(counts().of(CameraCause::kChanged), 1U);
    EXPECT_EQ(counts().losses, 1U);
    EXPECT_EQ(viewer_.watch().trouble().cause, CameraCause::kChanged) << describe(viewer_.watch().trouble());
    recover();
    expect_health("after");
  }

 private:
  std::unique_ptr<CameraStage> stage_ = GetParam().maker.make();
  CameraViewer viewer_{*stage_, GetParam().maker};
};

// `percent` of the frames never come, or come damaged; all the others do.
inline void endure_gaps(CameraFaults& test, CameraFault fault, int percent) {
  const CameraFaults::Seen seen = test.endure(fault, percent);
  const CameraCounts& counts = test.counts();
  const std::uint64_t gaps = fault == CameraFault::kDropped ? counts.dropped : counts.damaged;
  const double expected_frames =
      test.stage().setup().rate * static_cast<double>(test.maker().faults_last.count());
  const std::uint64_t others = fault == CameraFault::kDropped ? counts.damaged : counts.dropped;
  const double all = static_cast<double>(seen.frames + gaps);
  EXPECT_NEAR(all, expected_frames, 3.0 + test.frames_late());
  // Real drivers throw dice: five standard deviations.
  const double expected = all * percent / 100.0;
  const double spread = test.maker().stamped ? 1.0 : 5.0 * std::sqrt(expected * (100 - percent) / 100.0);
  EXPECT_NEAR(static_cast<double>(gaps), expected, spread + 1.0 + test.frames_late());
  EXPECT_EQ(others, 0U);
}

inline void endure_clock_step(CameraFaults& test, std::chrono::nanoseconds step) {
  const CameraFaults::Seen seen = test.endure(CameraFault::kTimestampStep, step.count());
  EXPECT_NEAR(static_cast<double>(seen.frames), 10.0 * test.stage().setup().rate, 2.0);
  EXPECT_EQ(test.counts().clock_steps, 1U);
  EXPECT_EQ(test.counts().dropped, 0U);
}

inline std::vector<CameraFaultCase> camera_fault_cases() {
  using F = CameraFault;
  using C = CameraCause;
  using namespace std::chrono_literals;
  return {
      {"OneInAHundredDropped", {F::kDropped}, [](CameraFaults& test) { endure_gaps(test, F::kDropped, 1); }},
      {"OneInTenDropped", {F::kDropped}, [](CameraFaults& test) { endure_gaps(test, F::kDropped, 10); }},
      {"HalfDropped", {F::kDropped}, [](CameraFaults& test) { endure_gaps(test, F::kDropped, 50); }},
      {"AllDropped", {F::kDropped}, [](CameraFaults& test) { test.lose(F::kDropped, 100, C::kSilent); }},
      {"OneInAHundredDamaged", {F::kDamaged}, [](CameraFaults& test) { endure_gaps(test, F::kDamaged, 1); }},
      {"OneInTenDamaged", {F::kDamaged}, [](CameraFaults& test) { endure_gaps(test, F::kDamaged, 10); }},
      {"HalfDamaged", {F::kDamaged}, [](CameraFaults& test) { endure_gaps(test, F::kDamaged, 50); }},
      {"AllDamaged", {F::kDamaged}, [](CameraFaults& test) { test.lose(F::kDamaged, 100, C::kSilent); }},
      {"AllTooShort", {F::kShort}, [](CameraFaults& test) { test.lose(F::kShort, 0, C::kSilent); }},
      {"TenSecondsOfSilence", {F::kSilent}, [](CameraFaults& test) { test.lose(F::kSilent, 0, C::kSilent); }},
      {"NoSignal", {F::kNoSignal}, [](CameraFaults& test) { test.lose(F::kNoSignal, 0, C::kNoSignal); }},
      {"Unplugged", {F::kUnplugged}, [](CameraFaults& test) { test.lose(F::kUnplugged, 0, C::kMissing); }},
      {"UnpluggedAHundredTimes",
       {F::kUnplugged},
       [](CameraFaults& test) {
         test.expect_health("before");
         for (int i = 0; i < 100 && !testing::Test::HasFailure(); ++i) {
           // Out of step with frames and attempts.
           test.lose_briefly(F::kUnplugged, 0, C::kMissing, 7ms + i * 3ms);
         }
         test.expect_health("after");
         EXPECT_EQ(test.counts().losses, 100U);
         EXPECT_EQ(test.counts().of(C::kMissing), 100U);
         EXPECT_EQ(test.counts().starts, 101U);
       }},
      {"RefusesToStart",
       {F::kStartFails, F::kUnplugged},
       [](CameraFaults& test) {
         test.expect_health("before");
         test.stage().begin_fault(F::kUnplugged, 0);
         EXPECT_EQ(test.viewer().run(500ms).losses, 1);
         test.stage().end_faults();
         test.stage().begin_fault(F::kStartFails, 0);
         EXPECT_EQ(test.viewer().run(10s).losses, 0) << "it was told already";
         EXPECT_EQ(test.counts().of(C::kFailed), 1U);
         EXPECT_EQ(test.counts().losses, 1U);
         test.recover();
         test.expect_health("after");
       }},
      {"WrongSizeOnReturn",
       {F::kWrongSize, F::kUnplugged},
       [](CameraFaults& test) { test.return_changed(F::kWrongSize); }},
      {"WrongFormatOnReturn",
       {F::kWrongFormat, F::kUnplugged},
       [](CameraFaults& test) { test.return_changed(F::kWrongFormat); }},
      {"WrongStrideOnReturn",
       {F::kWrongStride, F::kUnplugged},
       [](CameraFaults& test) { test.return_changed(F::kWrongStride); }},
      {"ClockBackAnHour", {F::kTimestampStep}, [](CameraFaults& test) { endure_clock_step(test, -1h); }},
      {"ClockBackTwoFrames", {F::kTimestampStep}, [](CameraFaults& test) { endure_clock_step(test, -34ms); }},
      {"ClockAhead", {F::kTimestampStep}, [](CameraFaults& test) { endure_clock_step(test, 1h); }},
      {"ClockFarAhead",
       {F::kTimestampStep},
       [](CameraFaults& test) { endure_clock_step(test, std::chrono::nanoseconds::max() - 5s); }},
  };
}

// Every case that a maker's stage can do.
inline std::vector<CameraFaultParam> camera_fault_cases(const std::vector<CameraStageMaker>& makers) {
  std::vector<CameraFaultParam> params;
  for (const CameraStageMaker& maker : makers) {
    for (const CameraFaultCase& fault : camera_fault_cases()) {
      const bool can = std::ranges::all_of(
          fault.needs, [&](CameraFault need) { return std::ranges::count(maker.faults, need) > 0; });
      if (can) params.push_back({maker, fault});
    }
  }
  return params;
}

TEST_P(CameraFaults, AreCountedToldAndOverSoon) {
  GetParam().fault.run(*this);
}

}  // namespace cupola
