// Starting the cameras, agreeing on what they send, and pacing by the flip.
// SPDX-License-Identifier: MIT
#include "firmware/live_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "pipeline/frame/error.h"
#include "pipeline/source/face_part.h"
#include "pipeline/warp/texels_read.h"

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
  const bool known = setup.width > 0 && setup.formats.size() == 1 && setup.formats[0] != CameraFormat::kMjpeg;
  if (!known || setup.crop.width != 0) {
    throw Failure(
        fmt::format("camera of view {}: {}; with a size, one format but MJPG, and no crop in the rig it "
                    "would be waited for",
                    camera.view, describe(watch.trouble())));
  }
  CameraMode mode;
  mode.format = setup.formats[0];
  mode.width = setup.width;
  mode.height = setup.height;
  mode.rate = setup.rate;
  return mode;
}

// As it was started, for certain: drivers that are asked for no size go on with their last one.
CameraSetup whole_setup(const CameraSetup& asked, const CameraMode& whole) {
  CameraSetup setup = asked;
  if (asked.crop.width == 0) {
    setup.width = whole.width;
    setup.height = whole.height;
  }
  return setup;
}

// None where there is too little to spare, or nothing is known of the camera yet.
std::optional<CameraSetup> cropped_setup(const CameraSetup& asked, const LiveView& view) {
  constexpr int kStep = 16;  // texels: no driver is known whose rows are in larger pieces
  const CameraMode& whole = view.mode;
  if (whole.crop.width == 0 || (asked.crop.width > 0 && asked.width == 0)) return std::nullopt;
  TexelBox box = view.needed;
  box.x0 = box.x0 / kStep * kStep;
  box.x1 = std::min((box.x1 + kStep - 1) / kStep * kStep, whole.width);
  const std::int64_t needed = std::int64_t{box.x1 - box.x0} * (box.y1 - box.y0);
  if (8 * needed > 7 * std::int64_t{whole.width} * whole.height) return std::nullopt;
  CameraSetup setup = whole_setup(asked, whole);
  setup.crop = area_of(box, whole);
  return setup;
}

void expect_alike(std::span<const LiveView> views) {
  const CameraMode& first = views[0].mode;
  for (const LiveView& view : views) {
    if (!layout_of(view.mode.format)) {
      throw Failure(
          fmt::format("camera of view {}: sends {}; expected YUYV, UYVY, NV12, P010, YU12, 422P, GREY, RGB3, "
                      "BGR3 or XR24",
                      view.name, name_of(view.mode.format)));
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

LiveFrames::LiveFrames(const Rig& rig, std::vector<OpenCamera> cameras, const LiveSettings& settings, Cpu cpu,
                       WorkerPool& pool, Clock& clock, TableCache* cache)
    : rig_(rig), cameras_(std::move(cameras)), clock_(clock), lead_(kFirstLead), latencies_(kLatencies) {
  std::vector<LiveView> views = start_cameras();
  expect_alike(views);
  std::vector<Size> sizes;
  for (const LiveView& view : views) sizes.push_back({view.mode.width, view.mode.height});
  set_view_sizes(rig_, sizes);
  for (const Size size : sizes) changed_.emplace_back(size);
  history_ = std::make_unique<ChangeHistory>(sizes);
  warp_ = make_native_to_xrgb_warp(rig_, *layout_of(views[0].mode.format), cpu, pool, cache);
  if (views[0].mode.rate > 0.0) rate_ = views[0].mode.rate;
  begin_colours(views[0].mode, settings.match_colours);
  if (settings.nv12) begin_nv12(views[0].mode, cpu, pool, cache);
  crop_cameras(views);
  std::vector<TexelBox> looked_at;
  for (const LiveView& view : views) {
    looked_at.push_back(view.camera ? view.needed : TexelBox());
    watches_.push_back(view.camera);
  }
  if (settings.exposure) exposure_.emplace(*settings.exposure, std::move(looked_at));
  if (settings.align) alignment_.emplace(views.size(), nanoseconds(std::llround(1e9 / rate_)));
  faces_ = std::make_unique<LiveFaces>(std::move(views), clock_, settings.sync);
}

void LiveFrames::begin_colours(const CameraMode& mode, bool match) {
  std::vector<std::optional<ViewColour>> locked;
  for (const View& view : rig_.views) {
    const OpenCamera* camera = camera_of(view.name);
    locked.push_back(camera ? camera->settings.colour : std::nullopt);
    locked_.push_back(locked.back().value_or(ViewColour{}));
  }
  const bool none =
      std::none_of(locked.begin(), locked.end(), [](const auto& colour) { return colour.has_value(); });
  if (none) locked_.clear();
  if (none && !match) return;
  if (!warp_->prepare_colours(rig_)) {
    throw Failure(fmt::format("{}: cameras send {}; expected YUV where colours are matched or locked",
                              rig_.file.string(), name_of(mode.format)));
  }
  warp_->set_colours(none ? std::vector<ViewColour>(rig_.views.size()) : locked_);
  if (!match) return;
  match_ = std::make_unique<ColourMatch>(rig_, *layout_of(mode.format), colour_of(mode), locked);
  if (match_->pairs() == 0) {
    throw Failure(
        fmt::format("{}: colour.match: no two views overlap, expected pictures that share some directions "
                    "of the frame",
                    rig_.file.string()));
  }
}

void LiveFrames::begin_nv12(const CameraMode& mode, Cpu cpu, WorkerPool& pool, TableCache* cache) {
  const auto refuse = [&](const std::string& why) {
    throw Failure(fmt::format("{}: display.format: expected XRGB8888, as {}", rig_.file.string(), why));
  };
  const NativeLayout layout = *layout_of(mode.format);
  if (is_rgb(layout) || sample_bytes(layout) > 1)
    refuse(fmt::format("cameras send {}", name_of(mode.format)));
  if (match_ || !locked_.empty()) refuse("colours are matched or locked");
  nv12_warp_ = make_nv12_warp(rig_, layout, cpu, pool, cache);
}

// By all warps together.
std::vector<TexelBox> LiveFrames::reads() const {
  std::vector<TexelBox> boxes = warp_->reads();
  const std::vector<TexelBox> more = nv12_warp_ ? nv12_warp_->reads() : boxes;
  for (std::size_t v = 0; v < boxes.size(); ++v) {
    boxes[v] = box_around(boxes[v], more[v]);
    if (match_) boxes[v] = box_around(boxes[v], match_->reads(v));
  }
  return boxes;
}

bool LiveFrames::follow_cameras() noexcept {
  unsigned seen = 0;
  for (std::size_t v = 0; v < changed_.size(); ++v) {
    if (faces_->sync().faces()[v].state == SyncedFace::State::kInStep) seen |= 1U << v;
  }
  follow_exposure(seen);
  follow_offsets();
  return follow_colours(seen);
}

void LiveFrames::follow_exposure(unsigned seen) noexcept {
  if (!exposure_ || !exposure_->look(faces_->faces(), seen, clock_.now())) return;
  const Exposure& exposure = exposure_->exposure();
  for (CameraWatch* const watch : watches_) {
    if (!watch) continue;
    watch->turn(CameraWatch::Dial::kExposure, exposure.us);
    if (exposure_->limits().most_gain > 1.0) watch->turn(CameraWatch::Dial::kGain, exposure.gain);
  }
}

void LiveFrames::follow_offsets() noexcept {
  if (!alignment_) return;
  for (std::size_t v = 1; v < watches_.size(); ++v) {
    if (!watches_[v]) continue;
    const auto frame = alignment_->look(v, faces_->sync().offset(v), clock_.now());
    if (frame) watches_[v]->turn(CameraWatch::Dial::kFrameTime, 1e-3 * static_cast<double>(frame->count()));
  }
}

bool LiveFrames::follow_colours(unsigned seen) noexcept {
  if (!match_) return false;
  if (!match_->look(faces_->faces(), seen, clock_.now())) return false;
  warp_->set_colours(match_->colours());
  return true;
}

// Those that are to be running and are not yet.
void LiveFrames::wait_for_starts(std::span<const LiveView> views) {
  const nanoseconds deadline = clock_.now() + kStartTime;
  for (;;) {
    nanoseconds wake = deadline;
    bool waiting = false;
    std::vector<int> descriptors;
    for (const LiveView& view : views) {
      if (!view.camera || view.camera->running()) continue;
      CameraFrame frame;
      if (view.camera->poll(frame) == CameraWatch::Poll::kFrame) view.camera->give_back(frame);
      wake = std::min(wake, view.camera->deadline());
      if (view.camera->running()) continue;
      waiting = true;
      descriptors.push_back(view.camera->descriptor());
    }
    if (!waiting || clock_.now() >= deadline) return;
    clock_.wait(descriptors, wake);
  }
}

std::vector<LiveView> LiveFrames::start_cameras() {
  std::vector<LiveView> views;
  for (const View& view : rig_.views) {
    const OpenCamera* camera = camera_of(view.name);
    views.push_back({view.name, camera ? camera->watch.get() : nullptr, {}, {}});
  }
  wait_for_starts(views);
  const LiveView* with_camera = nullptr;
  for (LiveView& view : views) {
    if (!view.camera) continue;
    view.mode = agreed_mode(camera_of(view.name)->settings, *view.camera);
    with_camera = &view;
  }
  if (!with_camera) throw Failure(fmt::format("{}: no view has a camera", rig_.file.string()));
  for (LiveView& view : views) {
    if (!view.camera) view.mode = with_camera->mode;
  }
  return views;
}

void LiveFrames::crop_cameras(std::span<LiveView> views) {
  const std::vector<TexelBox> boxes = reads();
  for (std::size_t v = 0; v < views.size(); ++v) {
    LiveView& view = views[v];
    view.needed = boxes[v];
    if (!view.camera) continue;
    if (view.needed.empty()) {
      std::exchange(view.camera, nullptr)->stop();
    } else if (const auto setup = cropped_setup(camera_of(view.name)->settings.setup, view)) {
      view.camera->set_setup(*setup);
    }
  }
  wait_for_starts(views);
  for (const LiveView& view : views) {
    if (!view.camera || !view.camera->running()) continue;
    const auto place = place_of(view.camera->mode(), view.mode);
    if (place && contains(*place, view.needed)) continue;
    view.camera->set_setup(whole_setup(camera_of(view.name)->settings.setup, view.mode));
  }
  wait_for_starts(views);
}

const OpenCamera* LiveFrames::camera_of(const std::string& view) const {
  const auto found = std::find_if(cameras_.begin(), cameras_.end(),
                                  [&](const OpenCamera& camera) { return camera.settings.view == view; });
  return found == cameras_.end() ? nullptr : &*found;
}

FrameMaker::Change LiveFrames::advance(const Due& due) noexcept {
  faces_->gather(due.flip - lead_);
  fresh_ = faces_->choose();
  if (fresh_) {
    const bool recoloured = follow_cameras();
    for (std::size_t v = 0; v < changed_.size(); ++v) {
      changed_[v].clear();
      if (recoloured || (faces_->changed() >> v & 1) != 0) changed_[v].add_all();
    }
    history_->fetched(changed_);
  }
  return fresh_ ? Change::kNew : Change::kUnchanged;
}

void LiveFrames::advance_unseen() noexcept {
  faces_->gather(clock_.now());
  if (faces_->choose()) follow_cameras();
  fresh_ = false;
}

template <class Frame>
WarpWork LiveFrames::warp_by(NativeWarp<Frame>& warp, const Frame& frame, int age) noexcept {
  const nanoseconds begun = clock_.now();
  const std::span<const ChangedCells> differs = history_->take(age);
  unsigned changed = differs.empty() ? ~0U : 0U;
  for (std::size_t v = 0; v < differs.size(); ++v) changed |= differs[v].count() > 0 ? 1U << v : 0U;
  const WarpWork work = warp.warp_changed(faces_->faces(), changed, frame);
  note_warp_since(begun);
  return work;
}

WarpWork LiveFrames::warp(const MutableImage& frame, int age) noexcept {
  return warp_by(*warp_, frame, age);
}

WarpWork LiveFrames::warp_nv12(const MutableNativeImage& frame, int age) noexcept {
  return warp_by(*nv12_warp_, frame, age);
}

std::optional<YuvColour> LiveFrames::nv12_colour() const noexcept {
  if (!nv12_warp_) return std::nullopt;
  return faces_->faces()[0].colour;
}

// Quick to grow and slow to shrink: a late frame is worse than an early choice.
void LiveFrames::note_warp_since(nanoseconds begun) noexcept {
  const nanoseconds took = clock_.now() - begun + kMargin;
  lead_ = std::max(took, lead_ - (lead_ - took) / 64);
}

FacePicture LiveFrames::face(std::size_t view) const noexcept {
  if (view >= rig_.views.size()) return {};
  return NativePart{faces_->faces()[view], faces_->needed(view)};
}

void LiveFrames::shown(nanoseconds flipped_at) noexcept {
  const nanoseconds captured_at = faces_->sync().captured_at();
  if (!std::exchange(fresh_, false) || captured_at == nanoseconds(0)) return;
  latencies_.add(flipped_at - captured_at);
}

void LiveFrames::report(ShowReport& report) const noexcept {
  if (exposure_) report.exposure = {exposure_->exposure(), exposure_->brightness()};
  report.camera_count = std::min(cameras_.size(), report.cameras.size());
  for (std::size_t c = 0; c < report.camera_count; ++c) {
    CameraReport& camera = report.cameras[c];
    const CameraCounts& counts = cameras_[c].watch->counts();
    camera.frames = counts.frames;
    camera.dropped = counts.dropped;
    camera.damaged = counts.damaged;
    camera.losses = counts.losses;
    for (std::size_t v = 0; v < rig_.views.size(); ++v) {
      if (rig_.views[v].name != cameras_[c].settings.view) continue;
      camera.shown = static_cast<CameraReport::Shown>(faces_->sync().faces()[v].state);
      const SyncOffset offset = faces_->sync().offset(v);
      camera.offset = offset.offset;
      camera.drift_ppm = offset.drift_ppm;
      if (match_) {
        camera.colour = match_->colours()[v];
      } else if (!locked_.empty()) {
        camera.colour = locked_[v];
      }
    }
  }
}

}  // namespace cupola
