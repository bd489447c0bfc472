// Faces drawn from a generated world: its backdrop once, at the start; what moves in it anew each frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/source/face_source.h"
#include "pipeline/source/world.h"

namespace cupola {

// Each texel is the mean over its area. Frame n has the same bits whatever was fetched before and however
// many threads there are.
class GeneratedSource final : public FaceSource {
 public:
  // Views without a size get `default_size`. `pool` is borrowed until prepare() returns; fetch() works on the
  // calling thread alone. `format`: planar RGB of 8 or 16 bits.
  GeneratedSource(std::span<const View> views, const Mat3& world_from_lens,
                  std::unique_ptr<const World> world, double frames_per_second, WorkerPool& pool,
                  Size default_size = {1024, 1024}, PixelFormat format = PixelFormat::kRgbPlanar8);

  std::vector<Size> face_sizes() const override;
  PixelFormat format() const override { return format_; }
  std::optional<std::int64_t> length() const override { return std::nullopt; }
  void prepare(std::span<const NeededRegion> needed) override;
  Fetch fetch(std::int64_t frame, FaceSet& faces) noexcept override;

  // Texels of the backdrop drawn by prepare(), and those left out because nobody needs them.
  std::int64_t texels_drawn() const { return texels_drawn_; }
  std::int64_t texels_skipped() const { return texels_skipped_; }
  // Texels drawn anew by the last fetch().
  std::int64_t texels_redrawn() const { return texels_redrawn_; }

 private:
  struct Face {
    View view;           // in the world's own space
    double texel = 0.0;  // radians, the widest one's diagonal half
    double reach = 0.0;  // cosine of the farthest corner's angle from view.forward; -2: not known
    NeededRegion needed;
    ImageBuffer backdrop;              // kRgbPlanar16
    ImageBuffer canvas;                // kRgbPlanar16: backdrop and sprites; empty when nothing moves
    ImageBuffer output;                // kRgbPlanar8; empty when 16 bits are asked for
    std::vector<std::uint8_t> uneven;  // texels whose backdrop varies within
    std::vector<TexelBox> boxes;       // one a sprite: where the canvas has it
  };

  void draw_backdrop(Face& face, int first_row, int last_row) const;
  void clear(Face& face, const TexelBox& box) const;
  void draw(Face& face, const Sprite& sprite, const TexelBox& box);
  void put_out(Face& face, const TexelBox& box) const;
  bool backdrop_is_canvas() const { return sprites_.empty(); }

  std::vector<Face> faces_;
  std::unique_ptr<const World> world_;
  double frames_per_second_;
  WorkerPool& pool_;
  PixelFormat format_;
  std::vector<Sprite> sprites_;  // as drawn
  std::vector<Sprite> next_sprites_;
  std::vector<ChangedCells> changed_;  // by the last fetch()
  bool fetched_ = false;
  std::int64_t texels_drawn_ = 0;
  std::int64_t texels_skipped_ = 0;
  std::int64_t texels_redrawn_ = 0;
};

}  // namespace cupola
