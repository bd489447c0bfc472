// The measurements of `cupola bench warp`: time and error of every method, on the same pictures in one
// process.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

// The paper's frame, 1966 x 1436, scaled to a circle of any diameter, with four faces.
Rig paper_shape(int circle, int face);

// A way to make a frame: a method, and for the EWA family its filter.
struct Contender {
  std::string name;
  Method method = Method::kEwa;
  FilterSettings filter;
};

// Error against the exact pixel integral of analytic scenes.
struct QualityRow {
  std::string contender;
  int minification = 1;         // texels of a face a pixel of the circle, 1, 2 or 4
  std::vector<double> psnr_db;  // one a scene
  double milliseconds = 0.0;    // a frame of this size on one core
  double ns_per_pixel = 0.0;    // in-image pixels
  std::size_t table_bytes = 0;
  bool peer = false;  // somebody else's
};
struct Quality {
  std::vector<std::string> scenes;
  std::vector<QualityRow> rows;
};
// Peers, where there are any, follow the contenders. `circle`: the frame's diameter in pixels; the faces have
// circle * 512 / 983 texels a side at 1:1.
Quality measure_quality(const std::vector<Contender>& contenders, const std::vector<std::string>& scenes,
                        int circle, WorkerPool& pool);

// Time on one core: medians over interleaved rounds of the thread's processor time.
struct SpeedRow {
  std::string name;
  double milliseconds = 0.0;
  double ns_per_pixel = 0.0;  // in-image pixels
  double bytes_per_pixel = 0.0;
  double rms = -1.0;  // 8-bit steps against ewa-exact on noise; below 0: not measured
  double max = -1.0;
};
// One thing to be timed, and where its times go.
struct Lap {
  SpeedRow row;
  std::function<void()> work;
  std::vector<double> times;
};
struct Speed {
  std::int64_t pixels_in_image = 0;
  std::vector<SpeedRow> rows;  // the first is memcpy of the frame, the second the peer where there is one
};
// `rig` with sizes; `with_error`: measure rows of the table warp against the reference too (slow).
Speed measure_speed(const Rig& rig, int rounds, bool with_error, WorkerPool& pool);

// What the table is for: the filters worth comparing, the shipped default first.
std::vector<Contender> usual_contenders();

}  // namespace cupola
