// Counters as JSON.
// SPDX-License-Identifier: MIT
#include "firmware/play_report.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstring>

#include "firmware/file_report.h"
#include "firmware/percentile.h"
#include "firmware/skip_report.h"

namespace cupola {
namespace {

nlohmann::ordered_json live_stats(const LiveFrames& live) {
  const Percentiles latency(live.latencies_ms());
  const RigSync& sync = live.faces().sync();
  nlohmann::ordered_json stats = {{"sets", sync.counts().sets},
                                  {"whole_sets", sync.counts().whole},
                                  {"frames_passed_over", sync.counts().passed_over},
                                  {"latency_ms_median", latency.at(0.5)},
                                  {"latency_ms_p99", latency.at(0.99)},
                                  {"latency_ms_max", latency.at(1.0)},
                                  {"cameras", nlohmann::ordered_json::array()}};
  for (const OpenCamera& camera : live.cameras()) {
    const CameraCounts& counts = camera.watch->counts();
    const CameraMode& mode = camera.watch->mode();
    stats["cameras"].push_back({{"view", camera.settings.view},
                                {"texels", {mode.width, mode.height}},
                                {"crop", {mode.crop.x, mode.crop.y, mode.crop.width, mode.crop.height}},
                                {"frames", counts.frames},
                                {"dropped", counts.dropped},
                                {"damaged", counts.damaged},
                                {"losses", counts.losses},
                                {"silences", counts.silences},
                                {"clock_steps", counts.clock_steps}});
    if (!camera.recording) continue;
    const RecorderCounts recorded = camera.recording->counts();
    stats["cameras"].back()["frames_recorded"] = recorded.frames;
    stats["cameras"].back()["frames_not_recorded"] = recorded.passed_over;
  }
  return stats;
}

}  // namespace

nlohmann::ordered_json play_stats(const FrameLoop& loop, const GpioCounts& gpio, const ShowFrames& frames) {
  const LiveFrames* live = frames.live();
  const LoopCounts& counts = loop.counts();
  const Percentiles warp(loop.warp_ms());
  nlohmann::ordered_json stats = {
      {"frames_presented", counts.frames_presented},
      {"frames_late", counts.frames_late},
      {"frames_dropped", counts.frames_dropped},
      {"frames_unshown", counts.frames_unshown},
      {"display_losses", counts.display_losses},
      {"frames_unchanged", counts.frames_unchanged},
      {"frames_nv12", counts.frames_nv12},
      {"frames_failed", counts.frames_failed},
      {"blackout_frames", counts.blackout_frames},
      {"gpio_edges", gpio.edges},
      {"gpio_losses", gpio.losses},
      {"gpio_returns", gpio.returns},
      {"heap_allocations", counts.heap_allocations},
      {"heap_allocations_elsewhere", counts.heap_allocations_elsewhere},
      {"dropped_by_faces", counts.dropped_by_faces},
      {"dropped_by_warp", counts.dropped_by_warp},
      {"dropped_by_display", counts.dropped_by_display},
      {"preview_bytes_copied", counts.preview_bytes_copied},
      {"pixel_bytes_copied", counts.pixel_bytes_copied + (live ? live->pixel_bytes_copied() : 0)},
      {"warp_ms_median", warp.at(0.5)},
      {"warp_ms_p99_9", warp.at(0.999)},
      {"warp_ms_max", warp.at(1.0)}};
  report_skips(counts.tiles, frames.texels_unneeded(), frames.file_counts().repeated, stats);
  stats["files"] = describe(frames.file_counts());
  if (live) stats["live"] = live_stats(*live);
  return stats;
}

void report_recordings(const LiveFrames& live) {
  for (const OpenCamera& camera : live.cameras()) {
    if (!camera.recording) continue;
    const RecorderCounts counts = camera.recording->counts();
    const std::string& view = camera.settings.view;
    if (counts.error != 0) {
      fmt::print(stderr, "cupola: the recording of view {} ended early: {}\n", view,
                 std::strerror(counts.error));
    }
    if (counts.passed_over > 0) {
      fmt::print(stderr, "cupola: the recording of view {} lacks {} frames that the disk was too slow for\n",
                 view, counts.passed_over);
    }
  }
}

}  // namespace cupola
