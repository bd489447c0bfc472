// A live show on fake cameras, a fake display and a fake clock, for tests.
// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/frame_loop.h"
#include "firmware/live_frames.h"
#include "firmware/show.h"
#include "hal/camera/fake_camera.h"
#include "hal/display/fake_display.h"

namespace cupola::test {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

inline constexpr int kWidth = 64;
inline constexpr int kHeight = 48;
inline constexpr Size kFace{48, 48};
inline constexpr std::array<const char*, 4> kViews = {"front", "left", "right", "top"};

inline Rig small_rig() {
  const std::string lines[] = {"frame.width=64", "frame.height=48", "frame.center=[32, 24]",
                               "frame.radius=30"};
  return load_named_rig("omnimax", lines);
}

// Shows frames and lets the test see each.
class SeenDisplay final : public Display {
 public:
  SeenDisplay(Clock& clock, Size size, std::function<void(int, DisplayBuffer)> see)
      : fake_(clock, size.width, size.height), see_(std::move(see)) {}
  DisplayBuffer back_buffer() noexcept override { return fake_.back_buffer(); }
  bool prepare_nv12(ScanoutColour colour) override { return fake_.prepare_nv12(colour); }
  DisplayBuffer back_nv12() noexcept override { return fake_.back_nv12(); }
  Presented present(nanoseconds when) noexcept override { return seen(fake_.present(when)); }
  Presented repeat(nanoseconds when) noexcept override { return seen(fake_.repeat(when)); }
  nanoseconds period() const noexcept override { return fake_.period(); }
  const char* trouble() const noexcept override { return fake_.trouble(); }
  FakeDisplay& fake() { return fake_; }

 private:
  Presented seen(Presented presented) noexcept {
    if (see_) see_(flips_++, fake_.front_buffer());
    return presented;
  }
  FakeDisplay fake_;
  std::function<void(int, DisplayBuffer)> see_;
  int flips_ = 0;
};

struct LiveColours {
  bool match = false;
  std::array<std::optional<ViewColour>, 4> locked{};
};

class LiveShow {
 public:
  using Wrap = std::function<std::unique_ptr<Camera>(std::size_t, std::unique_ptr<Camera>, FakeClock&)>;

  // `adjust` may change each camera's device and setup before it is made; `wrap` may put something about it,
  // or in its place.
  explicit LiveShow(const std::function<void(std::size_t, FakeCameraDevice&, CameraSetup&)>& adjust = {},
                    const Rig& rig = small_rig(), const Wrap& wrap = {}, const LiveColours& colours = {},
                    const LiveSettings& live = {}) {
    std::vector<OpenCamera> cameras;
    for (std::size_t c = 0; c < kViews.size(); ++c) {
      FakeCameraDevice device;
      device.number = static_cast<int>(c);
      device.formats = {CameraFormat::kNv12};
      device.width = kFace.width;
      device.height = kFace.height;
      device.latency = 4ms;
      RigCamera settings;
      settings.view = kViews[c];
      settings.patience = 100ms;
      settings.setup.width = kFace.width;
      settings.setup.height = kFace.height;
      settings.setup.formats = {CameraFormat::kNv12};
      settings.colour = colours.locked[c];
      if (adjust) adjust(c, device, settings.setup);
      auto camera = std::make_unique<FakeCamera>(clock, device);
      fakes.push_back(camera.get());
      std::unique_ptr<Camera> put = std::move(camera);
      if (wrap) put = wrap(c, std::move(put), clock);
      cameras.emplace_back(std::move(settings), std::move(put), clock);
    }
    LiveSettings settings = live;
    settings.match_colours = colours.match;
    frames = std::make_unique<LiveFrames>(rig, std::move(cameras), settings, best_cpu(), pool, clock);
  }

  LoopCounts play(nanoseconds time, std::function<void(int, DisplayBuffer)> see = {}) {
    SeenDisplay display(clock, frames->rig().frame.size, std::move(see));
    FrameLoop loop(*frames, display, clock, pool);
    EXPECT_EQ(loop.run(time), LoopEnd::kTimeUp);
    return loop.counts();
  }

  FakeClock clock;
  WorkerPool pool{1};
  std::vector<FakeCamera*> fakes;
  std::unique_ptr<LiveFrames> frames;
};

}  // namespace cupola::test
