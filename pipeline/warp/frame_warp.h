// A warp made ready: faces in, frame out, by any of the methods.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

enum class Method : std::uint8_t {
  kEwa,             // the fixed-point table: what the player uses
  kEwaExact,        // the reference: double precision, straight from the formulas
  kEwaScan,         // the 1986 scan with a weight table and finite differences, in float
  kEwaScanInteger,  // the same in integers
  kBilinear,        // for comparison
  kNearest,         // for comparison: point sampling
};

inline constexpr std::string_view kMethodNames[] = {"ewa",      "ewa-exact", "ewa-scan", "ewa-scan-integer",
                                                    "bilinear", "nearest"};

// Immutable once made, but for counters; one warp() at a time.
class FrameWarp {
 public:
  virtual ~FrameWarp() = default;
  // For each view the texels that warp() uses.
  virtual std::span<const NeededRegion> needed() const = 0;
  // `faces` in the rig's order, planar RGB of 8 or 16 bits and the rig's sizes. `frame` has the rig's frame
  // size and any format; every pixel of it is written, those outside the image 0.
  virtual void warp(std::span<const Image> faces, const MutableImage& frame) noexcept = 0;
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
