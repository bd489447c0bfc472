// RGB pictures of one plane, as some cameras send them, by the table that planes of RGB have.
// SPDX-License-Identifier: MIT
#include <cassert>

#include "pipeline/warp/band_run.h"
#include "pipeline/warp/native_views.h"
#include "pipeline/warp/native_warp.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/texels_read.h"
#include "pipeline/warp/views_read.h"
#include "pipeline/warp/yuv_warp.h"

namespace cupola {
namespace {

class PackedRgbWarp final : public NativeWarp<MutableImage> {
 public:
  PackedRgbWarp(const Rig& rig, WarpTable table, NativeLayout layout, Cpu cpu, WorkerPool& pool)
      : table_(std::move(table)),
        pool_(pool),
        views_(layout, rig.views),
        tiles_(table_, rgb_kernel(cpu, texel_step(layout)), nullptr),
        reads_(views_read(table_, tiles_)),
        rows_(row_store(cpu)),
        stages_(pool.threads(), [this] { return Stage<Xrgb>(table_); }) {}

  WarpWork warp_changed(std::span<const NativeImage> faces, unsigned changed,
                        const MutableImage& frame) noexcept override {
    assert(frame.format == PixelFormat::kXrgb8888 && frame.size == table_.frame);
    views_.set(faces);
    const ReflectedViews views = views_.rgb(table_);
    WorkSum sum;
    pool_.run(table_.tiles_down, [&](int band) {
      stages_.with_one([&](Stage<Xrgb>& stage) {
        sum.add(tiles_.warp(band, views, {}, stage, [&](std::size_t tile) {
          return wanted_images(reads_[tile], changed, tiles_.images_share());
        }));
        tiles_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
          rows_.store(stage.row(row, mirrored) + x, count, frame, x, y);
        });
        rows_.finish();
      });
    });
    return sum.total();
  }

  std::vector<TexelBox> reads() const override {
    std::vector<TexelBox> boxes = texels_read(table_);
    for (std::size_t v = 0; v < boxes.size(); ++v) {
      const Size size = views_.sizes()[v];
      if (views_.copies(v)) boxes[v] = {0, 0, size.width, size.height};
      if (!boxes[v].empty()) boxes[v] = even_box(boxes[v], size);
    }
    return boxes;
  }
  std::size_t table_bytes() const override { return table_.bytes(); }

 private:
  const WarpTable table_;
  WorkerPool& pool_;
  NativeViews views_;
  const BandTiles<Xrgb> tiles_;
  const ViewsRead reads_;
  const RowStore<Xrgb> rows_;
  PerThread<Stage<Xrgb>> stages_;
};

}  // namespace

std::unique_ptr<NativeWarp<MutableImage>> make_native_to_xrgb_warp(const Rig& rig, NativeLayout faces,
                                                                   Cpu cpu, WorkerPool& pool,
                                                                   TableCache* cache) {
  if (!is_rgb(faces)) return make_yuv_to_xrgb_warp(rig, faces, cpu, pool, cache);
  WarpTable table = cache ? cache->table(rig, pool) : build_warp_table(rig, pool);
  return std::make_unique<PackedRgbWarp>(rig, std::move(table), faces, cpu, pool);
}

}  // namespace cupola
