// libcamera on a machine that may have no camera: names, troubles, and a system that opens all the same.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_camera.h"

#include <gmock/gmock.h>

#include "hal/time/clock.h"

namespace cupola {
namespace {

using testing::VariantWith;

std::vector<LibcameraListing> dome() {
  return {{"/base/i2c@1/imx477@1a", "imx477", {}},
          {"/base/i2c@2/imx477@1a", "imx477", {}},
          {"/base/i2c@3/imx219@10", "imx219", {}}};
}

CameraCause cause_of(const std::variant<std::size_t, CameraTrouble>& answer) {
  return std::get<CameraTrouble>(answer).cause;
}

TEST(LibcameraSystem, FindsACameraByIdByItsOwnModelOrByPlace) {
  const auto cameras = dome();
  EXPECT_THAT(find_camera(cameras, "/base/i2c@2/imx477@1a"), VariantWith<std::size_t>(1));
  EXPECT_THAT(find_camera(cameras, "imx219"), VariantWith<std::size_t>(2));
  EXPECT_THAT(find_camera(cameras, "#0"), VariantWith<std::size_t>(0));
  EXPECT_THAT(find_camera(cameras, "#2"), VariantWith<std::size_t>(2));
}

TEST(LibcameraSystem, GuessesNotWhichOfSeveralCamerasIsMeant) {
  EXPECT_EQ(cause_of(find_camera(dome(), "imx477")), CameraCause::kUnsupported);
}

TEST(LibcameraSystem, MissesCamerasThatAreNotThere) {
  for (const char* name : {"", "#3", "#", "#-1", "#1x", "imx", "/base/i2c@2"}) {
    EXPECT_EQ(cause_of(find_camera(dome(), name)), CameraCause::kMissing) << name;
  }
  EXPECT_EQ(cause_of(find_camera({}, "")), CameraCause::kMissing);
  const std::vector<LibcameraListing> nameless{{"/base/usb", "", {}}};
  EXPECT_EQ(cause_of(find_camera(nameless, "")), CameraCause::kMissing);
}

TEST(LibcameraSystem, OpensWithWhateverIsPluggedInAndOpensAgain) {
  for (int i = 0; i < 2; ++i) {
    LibcameraSystem system;
    EXPECT_FALSE(system.trouble().has_value());
    for (const LibcameraListing& camera : system.list()) EXPECT_NE(camera.id, "");
    system.settle();
  }
  EXPECT_NE(LibcameraSystem::version(), "");
}

TEST(LibcameraCamera, OfAnUnknownNameIsMissing) {
  LibcameraSystem system;
  MonotonicClock clock;
  LibcameraCamera camera(system, clock);
  for (int i = 0; i < 2; ++i) {
    CameraSetup setup;
    setup.device = "no such camera";
    const auto answer = camera.start(setup);
    ASSERT_TRUE(std::holds_alternative<CameraTrouble>(answer));
    EXPECT_EQ(std::get<CameraTrouble>(answer).cause, CameraCause::kMissing);
    EXPECT_EQ(camera.descriptor(), -1);
  }
}

TEST(LibcameraCamera, ThatWasNeverStartedSaysAndDoesNothing) {
  LibcameraSystem system;
  MonotonicClock clock;
  LibcameraCamera camera(system, clock);
  CameraFrame frame;
  CameraTrouble trouble;
  EXPECT_EQ(camera.descriptor(), -1);
  EXPECT_EQ(camera.poll(frame, trouble), CameraPoll::kNothing);
  frame.buffer = 3;
  camera.give_back(frame);
  camera.stop();
}

}  // namespace
}  // namespace cupola
