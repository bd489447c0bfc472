// Rates, jitter and offsets from the frames' own timestamps.
// SPDX-License-Identifier: MIT
#include "firmware/camera_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace cupola {
namespace {

using std::chrono::nanoseconds;

double milliseconds(nanoseconds time) {
  return 1e-6 * static_cast<double>(time.count());
}

struct Seen {
  std::uint64_t sequence = 0;
  nanoseconds at{0};
};

// Looking at a picture takes milliseconds, which every frame would not leave.
constexpr nanoseconds kBetweenLooks = std::chrono::milliseconds(500);
constexpr int kKeptALook = 2;

struct Looks {
  std::optional<PictureFacts> facts;
  std::vector<TrialPicture> pictures;
  nanoseconds next{0};
  int to_keep = 0;
};

void look(const CameraFrame& frame, const CameraMode& mode, Looks& looks) {
  if (frame.captured_at >= looks.next) {
    looks.next = (frame.captured_at / kBetweenLooks + 1) * kBetweenLooks;
    looks.to_keep = kKeptALook;
    if (const auto facts = look_at(frame, mode)) looks.facts = facts;
  }
  if (looks.to_keep == 0) return;
  --looks.to_keep;
  if (auto grey = grey_of(frame)) looks.pictures.push_back({frame.captured_at, std::move(*grey)});
}

void collect(CameraWatch& camera, std::vector<Seen>& seen, Looks& looks) {
  CameraFrame frame;
  for (;;) {
    switch (camera.poll(frame)) {
      case CameraWatch::Poll::kFrame:
        seen.push_back({frame.sequence, frame.captured_at});
        look(frame, camera.mode(), looks);
        camera.give_back(frame);
        break;
      case CameraWatch::Poll::kBack:
      case CameraWatch::Poll::kLost:
        break;
      case CameraWatch::Poll::kNothing:
        return;
    }
  }
}

void measure_pace(const std::vector<Seen>& seen, TrialResult& result) {
  if (seen.size() < 2) return;
  const double span = milliseconds(seen.back().at - seen.front().at);
  if (span > 0.0) result.rate = 1e3 * static_cast<double>(seen.size() - 1) / span;
  double sum = 0.0;
  double squares = 0.0;
  int steps = 0;
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const double gap = milliseconds(seen[i].at - seen[i - 1].at);
    result.worst_gap_ms = std::max(result.worst_gap_ms, gap);
    if (seen[i].sequence != seen[i - 1].sequence + 1) continue;
    sum += gap;
    squares += gap * gap;
    ++steps;
  }
  if (steps > 0) result.jitter_ms = std::sqrt(std::max(0.0, squares / steps - sum / steps * (sum / steps)));
}

// Both in the order of time.
void measure_offset(const std::vector<Seen>& first, const std::vector<Seen>& other, TrialResult& result) {
  if (first.empty() || other.empty()) return;
  std::vector<double> offsets;
  std::size_t nearest = 0;
  for (const Seen& frame : first) {
    while (nearest + 1 < other.size() && std::chrono::abs(other[nearest + 1].at - frame.at) <=
                                             std::chrono::abs(other[nearest].at - frame.at)) {
      ++nearest;
    }
    // Beyond either end the nearest may be one that simply did not come.
    if (frame.at >= other.front().at && frame.at <= other.back().at) {
      offsets.push_back(milliseconds(other[nearest].at - frame.at));
    }
  }
  if (offsets.empty()) offsets.push_back(milliseconds(other[nearest].at - first.back().at));
  std::sort(offsets.begin(), offsets.end());
  result.offset_ms = offsets[offsets.size() / 2];
  result.offset_spread_ms = offsets.back() - offsets.front();
}

}  // namespace

std::vector<TrialResult> try_cameras(std::span<CameraWatch* const> cameras, Clock& clock, nanoseconds time) {
  std::vector<std::vector<Seen>> seen(cameras.size());
  std::vector<Looks> looks(cameras.size());
  std::vector<int> descriptors(cameras.size());
  const nanoseconds end = clock.now() + time;
  do {
    nanoseconds until = end;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      collect(*cameras[i], seen[i], looks[i]);
      descriptors[i] = cameras[i]->descriptor();
      until = std::min(until, cameras[i]->deadline());
    }
    clock.wait(descriptors, until);
  } while (clock.now() < end);
  std::vector<TrialResult> results(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraWatch& camera = *cameras[i];
    TrialResult& result = results[i];
    result.counts = camera.counts();
    if (result.counts.starts > 0) result.mode = camera.mode();
    if (result.counts.losses + result.counts.failed_starts > 0) result.trouble = camera.trouble();
    result.picture = looks[i].facts;
    result.pictures = std::move(looks[i].pictures);
    measure_pace(seen[i], result);
    if (i > 0) measure_offset(seen[0], seen[i], result);
  }
  return results;
}

std::vector<std::string> complaints(const TrialResult& result, double wanted_rate) {
  std::vector<std::string> all;
  const auto say = [&]<class... Value>(fmt::format_string<Value...> format, Value&&... value) {
    all.push_back(fmt::format(format, std::forward<Value>(value)...));
  };
  const CameraCounts& counts = result.counts;
  if (result.trouble) say("{}", describe(*result.trouble));
  if (!result.mode) return all;
  if (counts.losses > 0) say("lost {} times", counts.losses);
  if (counts.frames < 2) say("{} frames came", counts.frames);
  if (counts.dropped > 0) say("{} frames dropped", counts.dropped);
  if (counts.damaged > 0) say("{} frames damaged", counts.damaged);
  if (counts.clock_steps > 0) say("{} timestamps that cannot be", counts.clock_steps);
  if (wanted_rate > 0.0 && result.rate > 0.0 && std::abs(result.rate / wanted_rate - 1.0) > 0.02) {
    say("{:.2f} frames a second instead of {:g}", result.rate, wanted_rate);
  }
  return all;
}

}  // namespace cupola
