// The reference: the elliptical weighted average filter in double precision, straight from its formulas.
// Slow.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/footprint.h"

namespace cupola {

// One pixel, unrounded, in units of the faces' samples (0 to 255 or 65,535). Zero outside the image and where
// no view covers the ray. Greene & Heckbert 1986; with rec > 0 Heckbert 1989, section 3.5.
std::array<double, 3> ewa_exact(const Rig& rig, std::span<const Image> faces, int x, int y);

// The same for many pixels. Least-squares weights are those of FootprintGatherer in double precision: solving
// every pixel's own system, as ewa_exact does, would take hours a frame. const, for any number of threads.
class UnroundedFilter {
 public:
  explicit UnroundedFilter(const Rig& rig);  // borrowed
  std::array<double, 3> operator()(std::span<const Image> faces, int x, int y) const;

 private:
  const Rig& rig_;
  std::unique_ptr<const FootprintGatherer> gatherer_;  // kOptimal alone
};

// A whole frame: three doubles a pixel, row by row.
std::vector<double> ewa_exact_frame(const Rig& rig, std::span<const Image> faces, WorkerPool& pool);

}  // namespace cupola
