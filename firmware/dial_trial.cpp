// Errors at small size, since truth is dear; times at full size, since caches are small.
// SPDX-License-Identifier: MIT
#include "firmware/dial_trial.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "firmware/frame_error.h"
#include "pipeline/optics/frame_map.h"
#include "pipeline/source/ground_truth.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {
namespace {

constexpr int kSamples = 8;  // a pixel's side, for the truth
const char* const kWorlds[] = {"rotated-checker", "zone-plate", "grid"};

Size scaled(Size size, double by) {
  const auto side = [by](int texels) { return std::max(1, static_cast<int>(std::lround(texels * by))); };
  return {side(size.width), side(size.height)};
}

}  // namespace

Rig shrunk(const Rig& rig, int most) {
  Rig small = rig;
  const double by =
      std::min(1.0, static_cast<double>(most) / std::max(rig.frame.size.width, rig.frame.size.height));
  small.frame.size = scaled(rig.frame.size, by);
  small.frame.center *= by;
  small.frame.radius *= by;
  for (View& view : small.views) view.size = scaled(view.size, by);
  if (!small.frame.faces.empty()) {  // a cube's atlas must divide evenly
    const Size face = scaled(rig.frame.faces.front().size, by);
    for (View& view : small.frame.faces) view.size = face;
    const int rows = rig.frame.size.height / rig.frame.faces.front().size.height;
    small.frame.size = {face.width * rig.frame.columns, face.height * rows};
  }
  return small;
}

MachineTrial::MachineTrial(const Rig& rig, bool deep, Cpu cpu, WorkerPool& pool, TableCache* cache,
                           Clock& clock)
    : rig_(rig),
      deep_(deep),
      cpu_(cpu),
      pool_(pool),
      cache_(cache),
      clock_(clock),
      small_(shrunk(rig, kSmallSide)) {
  const FrameMap map = map_frame(small_, pool);
  for (const std::uint8_t owner : map.owner) small_image_.push_back(owner < FrameMap::kUncovered ? 1 : 0);
  scale_ = static_cast<double>(map_frame(rig, pool).in_image) /
           static_cast<double>(std::max<std::int64_t>(1, map.in_image));
  std::vector<NeededRegion> all;
  for (const View& view : small_.views) all.push_back(NeededRegion::all(view.size));
  const PixelFormat format = deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8;
  for (const char* name : kWorlds) {
    World world;
    world.source = std::make_unique<GeneratedSource>(small_.views, small_.world_from_lens, make_world(name),
                                                     60.0, pool, Size{}, format);
    world.source->prepare(all);
    world.source->fetch(0, world.set);
    world.truth =
        render_truth_exact(small_.frame, small_.world_from_lens, *make_world(name), 0.0, kSamples, pool);
    worlds_.push_back(std::move(world));
  }
}

double MachineTrial::median_ms(FrameWarp& warp, std::span<const Image> faces, Size frame) const {
  ImageBuffer into(PixelFormat::kXrgb8888, frame);
  std::vector<double> times;
  for (int i = -2; i < kFrames; ++i) {
    const auto begun = clock_.now();
    warp.warp(faces, into.pixels());
    if (i >= 0) times.push_back(std::chrono::duration<double, std::milli>(clock_.now() - begun).count());
  }
  std::nth_element(times.begin(), times.begin() + kFrames / 2, times.end());
  return times[kFrames / 2];
}

double MachineTrial::squared_error(const Image& frame, const std::vector<double>& truth) const {
  const auto width = static_cast<std::size_t>(frame.size.width);
  const std::size_t pixels = small_image_.size();
  double squares = 0.0;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (small_image_[i] == 0) continue;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const auto* row = frame.samples<std::uint16_t>(static_cast<int>(channel), static_cast<int>(i / width));
      const double error = row[i % width] / 257.0 - truth[channel * pixels + i];
      squares += error * error;
      ++count;
    }
  }
  return count == 0 ? 0.0 : squares / static_cast<double>(count);
}

DialTrial::Sketch MachineTrial::sketch(const FilterSettings& filter) {
  small_.filter = filter;
  const auto warp = make_frame_warp(small_, Method::kEwa, cpu_, pool_);
  ImageBuffer frame(PixelFormat::kRgbPlanar16, small_.frame.size);
  double squares = 0.0;
  for (const World& world : worlds_) {
    warp->warp(world.set.faces, frame.pixels());
    squares += squared_error(as_const(frame.pixels()), world.truth) / static_cast<double>(worlds_.size());
  }
  return {std::sqrt(squares), scale_ * median_ms(*warp, worlds_.front().set.faces, small_.frame.size)};
}

double MachineTrial::milliseconds(const FilterSettings& filter) {
  if (buffers_.empty()) {
    buffers_ = noise_faces(rig_);
    for (ImageBuffer& buffer : buffers_) {
      if (deep_) {
        ImageBuffer wide(PixelFormat::kRgbPlanar16, buffer.size());
        convert(as_const(buffer.pixels()), wide.pixels());
        buffer = std::move(wide);
      }
      noise_.push_back(as_const(buffer.pixels()));
    }
  }
  Rig rig = rig_;
  rig.filter = filter;
  const auto warp = make_frame_warp(rig, Method::kEwa, cpu_, pool_, cache_);
  return median_ms(*warp, noise_, rig_.frame.size);
}

}  // namespace cupola
