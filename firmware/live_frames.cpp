// Starting the cameras, agreeing on what they send, and pacing by the flip.
// SPDX-License-Identifier: MIT
#include "firmware/live_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "pipeline/frame/error.h"

namespace cupola {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

namespace {

constexpr nanoseconds kStartTime = 3s;
constexpr nanoseconds kMargin = 1ms;       // between the warp's end and the flip
constexpr nanoseconds kFirstLead = 8ms;    // until warps were timed
constexpr std::size_t kLatencies = 65536;  // 18 minutes at 60 a second

// What the camera sends, or, while it does not, what its rig says it will.
CameraMode agreed_mode(const RigCamera& camera, const CameraWatch& watch) {
  if (watch.counts().starts > 0) return watch.mode();
  const CameraSetup& setup = camera.setup;
  if (setup.width == 0 || setup.formats.size() != 1) {
    throw Failure(
        fmt::format("camera of view {}: {}; with a size and one format in the rig it would be waited for",
                    camera.view, describe(watch.trouble())));
  }
  CameraMode mode;
  mode.format = setup.formats[0];
  mode.width = setup.width;
  mode.height = setup.height;
  mode.crop = setup.crop;
  mode.rate = setup.rate;
  return mode;
}

void expect_alike(std::span<const LiveView> views) {
  const CameraMode& first = views[0].mode;
  for (const LiveView& view : views) {
    YuvLayout layout{};
    if (!layout_of(view.mode.format, layout)) {
      throw Failure(fmt::format("camera of view {}: sends {}; expected YUYV, UYVY, NV12 or YU12", view.name,
                                name_of(view.mode.format)));
    }
    if (view.mode.format != first.format || view.mode.bt709 != first.bt709 ||
        view.mode.full_range != first.full_range) {
      throw Failure(fmt::format(
          "camera of view {}: sends {}, and another colour or format than view {}; expected all alike",
          view.name, name_of(view.mode.format), views[0].name));
    }
  }
}

}  // namespace

LiveFrames::LiveFrames(const Rig& rig, std::vector<OpenCamera> cameras, const SyncSettings& settings, Cpu cpu,
                       WorkerPool& pool, Clock& clock)
    : rig_(rig), cameras_(std::move(cameras)), clock_(clock), lead_(kFirstLead), latencies_(kLatencies) {
  std::vector<LiveView> views = start_cameras();
  expect_alike(views);
  std::vector<Size> sizes;
  for (const LiveView& view : views) sizes.push_back({view.mode.width, view.mode.height});
  set_view_sizes(rig_, sizes);
  YuvLayout layout{};
  layout_of(views[0].mode.format, layout);
  warp_ = make_yuv_to_xrgb_warp(rig_, layout, cpu, pool);
  if (views[0].mode.rate > 0.0) rate_ = views[0].mode.rate;
  faces_ = std::make_unique<LiveFaces>(std::move(views), clock_, settings);
}

std::vector<LiveView> LiveFrames::start_cameras() {
  for (const OpenCamera& camera : cameras_) {
    watches_.push_back(std::make_unique<CameraWatch>(*camera.device, camera.settings.setup, clock_,
                                                     camera.settings.patience));
  }
  const nanoseconds deadline = clock_.now() + kStartTime;
  const auto all_started = [&] {
    return std::all_of(watches_.begin(), watches_.end(),
                       [](const auto& watch) { return watch->counts().starts > 0; });
  };
  for (;;) {
    nanoseconds wake = deadline;
    for (const auto& watch : watches_) {
      if (watch->counts().starts > 0) continue;
      CameraFrame frame;
      if (watch->poll(frame) == CameraWatch::Poll::kFrame) watch->give_back(frame);
      wake = std::min(wake, watch->deadline());
    }
    if (all_started() || clock_.now() >= deadline) break;
    clock_.wait({}, wake);
  }
  std::vector<LiveView> views;
  for (const View& view : rig_.views) {
    LiveView live;
    live.name = view.name;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      if (cameras_[c].settings.view != view.name) continue;
      live.camera = watches_[c].get();
      live.mode = agreed_mode(cameras_[c].settings, *watches_[c]);
    }
    views.push_back(std::move(live));
  }
  const auto with_camera =
      std::find_if(views.begin(), views.end(), [](const LiveView& view) { return view.camera; });
  if (with_camera == views.end()) throw Failure(fmt::format("{}: no view has a camera", rig_.file.string()));
  for (LiveView& view : views) {
    if (!view.camera) view.mode = with_camera->mode;
  }
  return views;
}

FrameMaker::Change LiveFrames::advance(nanoseconds /*time*/, nanoseconds flip) noexcept {
  faces_->gather(flip - lead_);
  fresh_ = faces_->choose();
  return fresh_ ? Change::kNew : Change::kUnchanged;
}

WarpWork LiveFrames::warp(const MutableImage& frame, int /*age*/) noexcept {
  const nanoseconds begun = clock_.now();
  warp_->warp(faces_->faces(), frame);
  // Quick to grow and slow to shrink: a late frame is worse than an early choice.
  const nanoseconds took = clock_.now() - begun + kMargin;
  lead_ = std::max(took, lead_ - (lead_ - took) / 64);
  return {1, 0};
}

void LiveFrames::shown(nanoseconds flipped_at) noexcept {
  const nanoseconds captured_at = faces_->sync().captured_at();
  if (!std::exchange(fresh_, false) || captured_at == nanoseconds(0)) return;
  latencies_[shown_++ % latencies_.size()] = flipped_at - captured_at;
}

std::vector<double> LiveFrames::latencies_ms() const {
  std::vector<double> times;
  for (std::size_t i = shown_ - std::min(shown_, latencies_.size()); i < shown_; ++i) {
    times.push_back(1e-6 * static_cast<double>(latencies_[i % latencies_.size()].count()));
  }
  return times;
}

}  // namespace cupola
