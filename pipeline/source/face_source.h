// The one interface behind which every kind of face comes: stills, sequences, generated worlds, cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/frame/changed_cells.h"
#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"

namespace cupola {

// The views' pictures of one instant, in the rig's order of views; planar RGB. Borrowed from the source until
// its next fetch.
struct FaceSet {
  std::vector<Image> faces;
  std::int64_t frame = 0;  // counts from 0
  // What differs from the set fetched before, a view each; none: anything may. Sources that know save the
  // warp work. Borrowed as the faces are.
  std::span<const ChangedCells> changed;
};

enum class Fetch : std::uint8_t {
  kNew,        // the faces are those of the frame asked for
  kUnchanged,  // the same, and no texel differs from the set fetched before
  kNotYet,     // the frame is not there in time; ask again
  kEnd,        // the source has no such frame
  kFailed,     // the frame could not be had
};

// Life: constructed (files are opened, sizes known; throws InputError) -> prepare, once -> fetch, often.
class FaceSource {
 public:
  virtual ~FaceSource() = default;
  // Texels of each view's picture, in the rig's order.
  virtual std::vector<Size> face_sizes() const = 0;
  // 8 or 16 bits a sample.
  virtual PixelFormat format() const = 0;
  // Number of frames; none when it never ends.
  virtual std::optional<std::int64_t> length() const = 0;
  // Allocates everything. `needed` tells for each view which texels will be used. Throws InputError.
  virtual void prepare(std::span<const NeededRegion> needed) = 0;
  // Any frame from 0, usually in rising order. Never throws. `faces` keeps its memory from call to call; what
  // it holds stands unless kNew or kUnchanged is given, but is made black ones where it holds none. A source
  // that is behind may give a frame that was due before, as kNew.
  virtual Fetch fetch(std::int64_t frame, FaceSet& faces) noexcept = 0;
};

}  // namespace cupola
