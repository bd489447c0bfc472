// Smaller copies of the faces, several an octave or one, made anew each frame and only where they are used.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/texel_spans.h"

namespace cupola {

enum class Reduction : std::uint8_t {
  kBox,       // each texel the mean of what it covers; one level an octave
  kGaussian,  // every level's texels are Gaussians of kLevelVariance; kLevelsAnOctave
};

// Of a texel's Gaussian, in texels^2 of its own level: narrower aliases, wider leaves EWA nothing to shape.
inline constexpr double kLevelVariance = 0.4;
inline constexpr int kLevelsAnOctave = 4;

// Level 0 are the faces. A level's view spans what the face spans, so that sizes need not divide evenly.
struct PyramidLevel {
  int parent = -1;          // made from this level
  double scale = 1.0;       // nominal: texels of the face a texel
  std::vector<Size> sizes;  // one a view, no side below 1
};

struct PyramidShape {
  Reduction reduction = Reduction::kBox;
  std::vector<PyramidLevel> levels;
  std::size_t views() const { return levels.front().sizes.size(); }
};

// Levels down to where no view has a side above one texel.
PyramidShape shape_pyramid(const Rig& rig, Reduction reduction);

// One output sample of a one-dimensional reduction: weights above 0 with the sum 2^14 over inputs from
// `first`.
struct ReductionTaps {
  std::int32_t first = 0;
  std::int32_t count = 0;
  std::uint32_t weights = 0;  // index of the first
};
struct LineReduction {
  std::vector<ReductionTaps> taps;  // one an output sample
  std::vector<std::uint16_t> weights;
};
LineReduction reduce_line(int from, int to, Reduction reduction, double from_variance);

// Images are numbered level * views + view. Samples have 16 bits at every level but 0: those of 8-bit faces
// are times 256.
class Pyramid {
 public:
  // `used`: the texels wanted of each image, those of level 0 among them.
  Pyramid(const PyramidShape& shape, std::vector<TexelSpans> used);

  // The texels of the faces that build() or its caller reads.
  std::span<const NeededRegion> needed() const { return needed_; }
  const TexelSpans& made(std::size_t image) const { return made_[image]; }
  std::size_t bytes() const;

  // Fills every level from `faces` (8 or 16 bits, planar).
  void build(std::span<const Image> faces, WorkerPool& pool) noexcept;
  // kRgbPlanar16; valid until the next build(). Not for level 0.
  Image image(std::size_t image) const { return images_[image].pixels(); }

 private:
  struct Step {  // one image made from another
    std::size_t to = 0;
    std::size_t from = 0;
    LineReduction across, down;
    std::vector<int> rows;  // of `to`, those used
  };
  void make_span(const Step& step, const Image& source, int row, RowSpan span,
                 std::span<std::uint32_t> line) noexcept;
  template <class Sample>
  void add_rows(const Step& step, const Image& source, int channel, int row, RowSpan columns,
                std::span<std::uint32_t> line) noexcept;

  std::size_t views_;
  std::vector<TexelSpans> made_;
  std::vector<NeededRegion> needed_;  // of the faces
  std::vector<ImageBuffer> images_;
  std::vector<Step> steps_;  // parents first
  std::size_t line_ = 0;     // the longest line of any source
  std::vector<std::uint32_t> lines_;
};

}  // namespace cupola
