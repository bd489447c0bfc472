// A warp made ready: faces in, frame out, by any of the methods.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "pipeline/frame/changed_cells.h"
#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/even_cells.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

enum class Method : std::uint8_t {
  kEwa,             // the fixed-point table: what the player uses
  kEwaExact,        // the reference: double precision, straight from the formulas
  kEwaScan,         // the 1986 scan with a weight table and finite differences, in float
  kEwaScanInteger,  // the same in integers
  kEwaPyramid,      // EWA on smaller copies of the faces where the picture shrinks
  kTwoPass,         // one-dimensional filters along one side and then the other, fitted to EWA
  kTrilinear,       // for comparison: mip-maps (Williams 1983)
  kSummedArea,      // for comparison: the mean over a rectangle (Crow 1984)
  kBilinear,        // for comparison
  kNearest,         // for comparison: point sampling
};

inline constexpr std::string_view kMethodNames[] = {
    "ewa",      "ewa-exact", "ewa-scan",    "ewa-scan-integer", "ewa-pyramid",
    "two-pass", "trilinear", "summed-area", "bilinear",         "nearest"};

// What a warp did and what it left out and why, in pieces of the frame of its own choice.
struct WarpWork {
  std::int64_t pieces = 0;   // filtered
  std::int64_t skipped = 0;  // left as they were, since nothing they show had changed
  std::int64_t even = 0;     // filled, since all they show is of one colour
  std::int64_t outside = 0;  // black, since they show nothing: beyond the circle, the crop or all views

  WarpWork& operator+=(const WarpWork& other) {
    pieces += other.pieces;
    skipped += other.skipped;
    even += other.even;
    outside += other.outside;
    return *this;
  }
};

// What is known of a set of faces, one a view each; either may be empty: nothing is known.
struct FaceKnowledge {
  std::span<const ChangedCells> changed;  // what differs from the faces that made what the frame holds
  std::span<const EvenCells> even;
};

// Immutable once made, but for counters; one warp() at a time.
class FrameWarp {
 public:
  virtual ~FrameWarp() = default;
  // For each view the texels that warp() uses.
  virtual std::span<const NeededRegion> needed() const = 0;
  // `faces` in the rig's order, planar RGB of 8 or 16 bits and the rig's sizes; the planes of a face have one
  // stride. `frame` has the rig's frame
  // size and any format; every pixel of it is written, those outside the image 0.
  virtual void warp(std::span<const Image> faces, const MutableImage& frame) noexcept = 0;
  // The same with as little work as what is `known` allows, which must be true. With `known.changed`, `frame`
  // holds what this warp made of other faces. Methods that cannot use that do all of it, unless nothing
  // changed.
  virtual WarpWork warp_known(std::span<const Image> faces, const FaceKnowledge& known,
                              const MutableImage& frame) noexcept;
  // Bytes of precomputed tables; 0 for none.
  virtual std::size_t table_bytes() const = 0;
};

// The rig's views must have sizes; the rig is copied where it is needed later. `pool` is borrowed for the
// warp's life. `cpu` and `cache` matter to kEwa only; without a cache tables are built.
std::unique_ptr<FrameWarp> make_frame_warp(const Rig& rig, Method method, Cpu cpu, WorkerPool& pool,
                                           TableCache* cache = nullptr);

// The left half of the frame by one method, the right half by another, side by side as in the paper's
// figure 6. Throws InputError for a rig whose frame has no centre (maps of the world, cubes) or is less than
// 2 pixels wide.
std::unique_ptr<FrameWarp> make_split_warp(const Rig& rig, Method left, Method right, Cpu cpu,
                                           WorkerPool& pool, TableCache* cache = nullptr);

}  // namespace cupola
