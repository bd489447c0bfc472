// A cue tried before it is played: its first and last frame, and whether this machine holds its rate.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "firmware/show.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

// What a frame takes, in milliseconds.
struct FrameCost {
  double rate = 0.0;                // frames a second that are asked for
  int threads = 1;                  // of the frame loop
  std::optional<double> decode_ms;  // on one core, ahead of the loop; none: nothing is decoded on the way
  double faces_ms = 0.0;            // made in the loop
  double warp_ms = 0.0;
  bool fades = false;  // two warps a frame
};

// The busiest stage's share of the time between two frames: the decoder's, which has a core, or the loop's,
// which has all of them but for what the decoder takes.
double share_of_frame(const FrameCost& cost);
// "60 a second; decode 4.1 ms on one core ahead, warp 3.2 ms; holds (38 % of a frame's time)".
std::string prediction(const FrameCost& cost);
inline bool holds(const FrameCost& cost) {
  return share_of_frame(cost) <= 1.0;
}

struct CueTrial {
  std::vector<std::string> faults;  // of its files
  std::string length;               // "30 s", "120 frames", "endless"
  FrameCost cost;                   // where there are none
};

// Tries cue after cue; warps are shared as a show shares them. All are borrowed.
class CueTrials {
 public:
  CueTrials(const Rig& rig, Cpu cpu, WorkerPool& pool, TableCache* cache);
  // Throws InputError. Measures for 2 seconds at most, but for one frame of whatever is slower.
  CueTrial run(const Cue& cue);

 private:
  using Needs = std::tuple<std::vector<Size>, PixelFormat, std::optional<Method>, bool>;
  struct Made {
    Needs needs;
    std::unique_ptr<FrameWarp> warp;
  };
  FrameWarp& warp_for(const Cue& cue, const FaceSource& source);

  const Rig& rig_;
  Cpu cpu_;
  WorkerPool& pool_;
  WorkerPool one_;  // what the decoder's thread has
  TableCache* cache_;
  std::vector<Made> made_;
};

}  // namespace cupola
