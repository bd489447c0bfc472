// The trial of a rig's cameras: known rates, jitter and offsets are measured, and what is wrong is said.
// SPDX-License-Identifier: MIT
#include "firmware/camera_trial.h"

#include <memory>

#include <gmock/gmock.h>

#include "hal/camera/fake_camera.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class CameraTrial : public testing::Test {
 protected:
  void add(const FakeCameraDevice& device) {
    cameras_.push_back(std::make_unique<FakeCamera>(clock_, device));
    owned_.push_back(std::make_unique<CameraWatch>(*cameras_.back(), CameraSetup{}, clock_, 500ms));
    watches_.push_back(owned_.back().get());
  }

  FakeClock clock_;
  std::vector<std::unique_ptr<FakeCamera>> cameras_;
  std::vector<std::unique_ptr<CameraWatch>> owned_;
  std::vector<CameraWatch*> watches_;
};

TEST_F(CameraTrial, MeasuresRateJitterAndOffset) {
  FakeCameraDevice steady;
  steady.rate = 60.0;
  add(steady);
  FakeCameraDevice shaky = steady;
  shaky.jitter = 2ms;
  add(shaky);
  const auto results = try_cameras(watches_, clock_, 2s);
  EXPECT_NEAR(results[0].rate, 60.0, 0.01);
  EXPECT_LT(results[0].jitter_ms, 0.001);
  EXPECT_NEAR(static_cast<double>(results[0].counts.frames), 120.0, 2.0);
  EXPECT_NEAR(results[1].rate, 60.0, 0.1);
  EXPECT_GT(results[1].jitter_ms, 0.4);
  EXPECT_LT(results[1].jitter_ms, 2.0);
  ASSERT_TRUE(results[1].offset_ms);
  EXPECT_GE(*results[1].offset_ms, 0.0);
  EXPECT_LE(*results[1].offset_ms, 2.0);
  EXPECT_LE(results[1].offset_spread_ms, 2.0);
  for (const TrialResult& result : results) EXPECT_THAT(complaints(result, 60.0), IsEmpty());
}

// A camera begins its half seconds when the clock does, so that of cameras in step there are pictures of one
// instant, whenever each of them came.
TEST_F(CameraTrial, KeepsPicturesOfTheSameInstants) {
  FakeCameraDevice first;
  first.rate = 60.0;
  add(first);
  FakeCameraDevice later = first;
  later.faults = {{CameraFault::kUnplugged, 0ns, 700ms}};
  later.jitter = 2ms;
  add(later);
  const auto results = try_cameras(watches_, clock_, 2s);
  EXPECT_EQ(results[0].pictures.size(), 8U) << "two in a half second";
  int together = 0;
  for (const TrialPicture& picture : results[1].pictures) {
    EXPECT_EQ(picture.grey.size, (Size{first.width, first.height}));
    EXPECT_GT(picture.at, 700ms);
    for (const TrialPicture& beside : results[0].pictures)
      together += std::chrono::abs(picture.at - beside.at) <= 10ms ? 1 : 0;
  }
  EXPECT_GE(together, 2) << "of those at one and at one and a half seconds";
}

TEST_F(CameraTrial, SaysWhatIsWrong) {
  FakeCameraDevice slow;
  slow.rate = 50.0;
  slow.faults = {{CameraFault::kDropped, 0ns, 10s, 30}};
  add(slow);
  FakeCameraDevice missing;
  missing.faults = {{CameraFault::kUnplugged}};
  add(missing);
  FakeCameraDevice silent;
  silent.faults = {{CameraFault::kSilent}};
  add(silent);
  const auto results = try_cameras(watches_, clock_, 2s);
  EXPECT_THAT(complaints(results[0], 60.0), Contains(HasSubstr("dropped")));
  EXPECT_THAT(complaints(results[0], 60.0), Contains(HasSubstr("instead of 60")));
  EXPECT_THAT(complaints(results[1], 60.0), Contains(HasSubstr("no such device")));
  EXPECT_FALSE(results[1].mode);
  EXPECT_FALSE(results[1].offset_ms);
  EXPECT_THAT(complaints(results[2], 60.0), Contains(HasSubstr("0 frames came")));
}

}  // namespace
}  // namespace cupola
