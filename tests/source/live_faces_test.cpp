// Faces from fake cameras on a fake clock: in step, late, lost and back, without a copy.
// SPDX-License-Identifier: MIT
#include "pipeline/source/live_faces.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <set>

#include "hal/camera/fake_camera.h"
#include "hal/camera/fake_picture.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kFlip = 16'666'667ns;

// Four cameras, a screen that asks 60 times a second.
class LiveRig {
 public:
  explicit LiveRig(CameraFormat format = CameraFormat::kNv12) {
    std::vector<LiveView> views;
    for (int c = 0; c < 4; ++c) {
      FakeCameraDevice device;
      device.number = c;
      device.formats = {format};
      device.latency = 3ms;
      cameras.push_back(std::make_unique<FakeCamera>(clock, device));
      CameraSetup setup;
      setup.width = device.width;
      setup.height = device.height;
      watches.push_back(std::make_unique<CameraWatch>(*cameras.back(), setup, clock, 100ms));
      CameraMode mode;
      mode.format = format;
      mode.width = device.width;
      mode.height = device.height;
      views.push_back({"FRONT", watches.back().get(), mode, {}});
    }
    // What a camera sends is what it says when it starts.
    for (int c = 0; c < 4; ++c) {
      CameraFrame frame;
      const auto i = static_cast<std::size_t>(c);
      watches[i]->poll(frame);
      views[i].mode = watches[i]->mode();
    }
    faces = std::make_unique<LiveFaces>(views, clock, SyncSettings{});
  }

  // One flip later.
  bool flip() {
    next += kFlip;
    faces->gather(next);
    return faces->choose();
  }

  // The stamp in a face's picture; none for a slate.
  std::optional<PictureStamp> stamp(std::size_t view) const {
    const NativeImage& image = faces->faces()[view];
    CameraFrame frame;
    frame.format = watches[view]->mode().format;
    frame.width = image.size.width;
    frame.height = image.size.height;
    for (std::size_t p = 0; p < plane_count(image.layout); ++p) {
      frame.planes[p].data = image.planes[p].data;
      frame.planes[p].stride = image.planes[p].stride;
      frame.planes[p].bytes = static_cast<std::size_t>(image.planes[p].stride) *
                              static_cast<std::size_t>(plane_bytes(image.layout, image.size, p).height);
    }
    return read_stamp(frame);
  }

  FakeClock clock;
  std::vector<std::unique_ptr<FakeCamera>> cameras;
  std::vector<std::unique_ptr<CameraWatch>> watches;
  std::unique_ptr<LiveFaces> faces;
  nanoseconds next{0};
};

class LiveFacesOf : public testing::TestWithParam<CameraFormat> {};

TEST_P(LiveFacesOf, ShowEveryFrameOfEveryCameraInTheDriversOwnMemory) {
  LiveRig rig(GetParam());
  rig.flip();
  rig.flip();
  std::uint32_t last = 0;
  for (int i = 0; i < 300; ++i) {
    EXPECT_TRUE(rig.flip());
    const auto first = rig.stamp(0);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->camera, 0);
    EXPECT_TRUE(i == 0 || first->sequence == last + 1);
    last = first->sequence;
    for (std::size_t c = 1; c < 4; ++c) {
      const auto stamp = rig.stamp(c);
      ASSERT_TRUE(stamp) << c;
      EXPECT_EQ(stamp->camera, static_cast<int>(c));
      EXPECT_EQ(stamp->sequence, last) << c;
    }
  }
  EXPECT_EQ(rig.faces->counts().pixel_bytes_copied, 0U);
  EXPECT_EQ(rig.faces->sync().counts().passed_over, 0U);
}

TEST(LiveFaces, ShowGreyPicturesWithoutColour) {
  LiveRig rig(CameraFormat::kGrey);
  for (int i = 0; i < 10; ++i) rig.flip();
  const auto expect_no_colour = [&] {
    for (const NativeImage& face : rig.faces->faces()) {
      ASSERT_EQ(face.layout, NativeLayout::kI420);
      const Size chroma = chroma_size(face.layout, face.size);
      for (int channel = 1; channel < 3; ++channel) {
        for (int y = 0; y < chroma.height; ++y) {
          for (int x = 0; x < chroma.width; ++x) ASSERT_EQ(*sample_at(face, channel, x, y), 128);
        }
      }
    }
  };
  expect_no_colour();
  rig.cameras[1]->begin_fault(CameraFault::kUnplugged);
  rig.flip();
  ASSERT_TRUE(rig.stamp(1)) << "its last picture";
  expect_no_colour();
}

INSTANTIATE_TEST_SUITE_P(Formats, LiveFacesOf,
                         testing::Values(CameraFormat::kNv12, CameraFormat::kP010, CameraFormat::kI420,
                                         CameraFormat::kYuyv, CameraFormat::kUyvy, CameraFormat::kI422,
                                         CameraFormat::kGrey, CameraFormat::kRgb24, CameraFormat::kBgr24,
                                         CameraFormat::kXrgb32),
                         [](const auto& format) { return std::string(name_of(format.param)); });

TEST(LiveFaces, ShowSlatesOfRgbInGrey) {
  const LiveRig rig(CameraFormat::kBgr24);
  const NativeImage& slate = rig.faces->faces()[2];
  ASSERT_EQ(slate.layout, NativeLayout::kBgr24);
  std::set<int> greys;
  for (int y = 0; y < slate.size.height; ++y) {
    for (int x = 0; x < slate.size.width; ++x) {
      greys.insert(*sample_at(slate, 0, x, y));
      ASSERT_EQ(*sample_at(slate, 0, x, y), *sample_at(slate, 1, x, y));
      ASSERT_EQ(*sample_at(slate, 0, x, y), *sample_at(slate, 2, x, y));
    }
  }
  EXPECT_EQ(greys.size(), 2U) << "letters on a ground";
}

TEST(LiveFaces, ShowTheLastPictureThenTheSlateAndTheCameraAgain) {
  LiveRig rig;
  for (int i = 0; i < 60; ++i) rig.flip();
  const auto last = rig.stamp(2);
  ASSERT_TRUE(last);
  rig.cameras[2]->begin_fault(CameraFault::kUnplugged);
  const nanoseconds unplugged = rig.clock.now();
  bool slate = false;
  for (int i = 0; i < 60; ++i) {
    const auto before = rig.stamp(0);
    rig.flip();
    EXPECT_EQ(rig.stamp(0)->sequence, before->sequence + 1) << "the others go on";
    const auto stamp = rig.stamp(2);
    if (rig.clock.now() - unplugged < 450ms) {
      ASSERT_TRUE(stamp) << i;
      EXPECT_LE(stamp->sequence - last->sequence, 1U);
    }
    slate = !stamp;
  }
  EXPECT_TRUE(slate);
  EXPECT_EQ(rig.faces->counts().pixel_bytes_copied, 64U * 48U * 3U / 2U) << "one picture, once";
  rig.cameras[2]->end_faults();
  int flips = 0;
  while (!rig.stamp(2)) {
    rig.flip();
    ASSERT_LE(++flips, 2 + 1) << "two frame periods after it is back, and the flip that shows it";
  }
  EXPECT_EQ(rig.watches[2]->counts().losses, 1U);
}

TEST(LiveFaces, PassOverFramesThatAreNotAsAgreed) {
  LiveRig rig;
  for (int i = 0; i < 10; ++i) rig.flip();
  rig.cameras[1]->begin_fault(CameraFault::kWrongSize);
  rig.cameras[1]->begin_fault(CameraFault::kUnplugged);
  rig.flip();
  rig.cameras[1]->end_faults();
  rig.cameras[1]->begin_fault(CameraFault::kWrongSize);
  for (int i = 0; i < 60; ++i) rig.flip();
  EXPECT_FALSE(rig.stamp(1));
  EXPECT_TRUE(rig.stamp(0));
}

TEST(LiveFaces, WritesTheViewsNameOnItsSlate) {
  FakeClock clock;
  CameraMode mode;
  mode.format = CameraFormat::kNv12;
  mode.width = mode.height = 128;
  LiveFaces faces({{"LEFT", nullptr, mode, {}}}, clock, {});
  faces.gather(0ns);
  EXPECT_FALSE(faces.choose());
  const NativeImage& slate = faces.faces()[0];
  int bright = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) bright += *sample_at(slate, 0, x, y) > 100;
  }
  EXPECT_GT(bright, 100);
  EXPECT_LT(bright, 128 * 128 / 8);
  EXPECT_EQ(*sample_at(slate, 1, 5, 5), 128);
}

}  // namespace
}  // namespace cupola
