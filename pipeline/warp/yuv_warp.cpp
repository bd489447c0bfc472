// Two tables at work on one frame.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/native_warp.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <optional>

#include "pipeline/frame/error.h"
#include "pipeline/warp/band_run.h"
#include "pipeline/warp/native_views.h"
#include "pipeline/warp/symmetry.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/texels_read.h"
#include "pipeline/warp/view_mix.h"
#include "pipeline/warp/views_read.h"
#include "pipeline/warp/yuv_rig.h"
#include "pipeline/warp/yuv_rows.h"
#include "pipeline/warp/yuv_warp.h"

namespace cupola {
namespace {

// What is kept of a band. One thread uses it at a time.
struct Stages {
  Stage<Luma> luma;
  Stage<Chroma> chroma;
};

struct Tables {
  WarpTable luma;
  WarpTable chroma;
};

bool same(const Reflection& a, const Reflection& b) {
  if (a.across != b.across || a.down != b.down) return false;
  for (std::size_t i = 0; i < kMostViews; ++i) {
    if (a.views[i].view != b.views[i].view || a.views[i].flip_u != b.views[i].flip_u ||
        a.views[i].flip_v != b.views[i].flip_v) {
      return false;
    }
  }
  return true;
}

WarpTable table_of(const Rig& rig, WorkerPool& pool, TableCache* cache) {
  return cache ? cache->table(rig, pool) : build_warp_table(rig, pool);
}

// Tables whose bands and mirror images are the same. The cache has tables with all their mirrors only.
Tables tables_in_step(const Rig& luma, const Rig& chroma, WorkerPool& pool, TableCache* cache) {
  const std::vector<Reflection> of_luma = find_reflections(luma);
  const std::vector<Reflection> of_chroma = find_reflections(chroma);
  std::vector<Reflection> shared;
  for (const Reflection& reflection : of_luma) {
    for (const Reflection& other : of_chroma) {
      if (same(reflection, other)) shared.push_back(reflection);
    }
  }
  const auto table = [&](const Rig& rig, std::size_t mirrors) {
    return shared.size() == mirrors ? table_of(rig, pool, cache) : build_warp_table(rig, shared, pool);
  };
  return {table(luma, of_luma.size()), table(chroma, of_chroma.size())};
}

// Both channels' boxes as luma texels of a face of that size.
TexelBox box_of_both(const TexelBox& luma, const TexelBox& chroma, NativeLayout layout, Size face) {
  if (luma.empty() && chroma.empty()) return {};
  const int rows = has_chroma_in_every_row(layout) ? 1 : 2;  // of luma in one of chroma
  const TexelBox of_chroma{2 * chroma.x0, rows * chroma.y0, 2 * chroma.x1, rows * chroma.y1};
  return even_box(box_around(luma, of_chroma), face);
}

TileKernel<Luma> luma_kernel_for(NativeLayout layout, Cpu cpu) {
  return sample_bytes(layout) == 2 ? wide_luma_kernel(cpu) : luma_kernel(cpu, texel_step(layout));
}

TileKernel<Chroma> chroma_kernel_for(NativeLayout layout, Cpu cpu) {
  return sample_bytes(layout) == 2 ? wide_chroma_kernel(cpu) : chroma_kernel(cpu, chroma_step(layout));
}

template <class Frame>
class TwoTableWarp : public NativeWarp<Frame> {
 public:
  TwoTableWarp(const Rig& rig, Tables tables, NativeLayout layout, Cpu cpu, WorkerPool& pool)
      : tables_(std::move(tables)),
        pool_(pool),
        layout_(layout),
        views_(layout, rig.views),
        luma_(tables_.luma, luma_kernel_for(layout, cpu), nullptr),
        chroma_(tables_.chroma, chroma_kernel_for(layout, cpu), nullptr),
        rows_(yuv_rows(cpu)),
        finish_(row_store(cpu).finish),
        stages_(pool.threads(), [this] {
          return Stages{Stage<Luma>(tables_.luma), Stage<Chroma>(tables_.chroma)};
        }) {}

  std::vector<TexelBox> reads() const override {
    const std::vector<TexelBox> luma = texels_read(tables_.luma);
    const std::vector<TexelBox> chroma = texels_read(tables_.chroma);
    std::vector<TexelBox> boxes;
    for (std::size_t v = 0; v < luma.size(); ++v) {
      const Size size = views_.sizes()[v];
      const TexelBox all{0, 0, size.width, size.height};
      boxes.push_back(views_.copies(v) ? all : box_of_both(luma[v], chroma[v], layout_, size));
    }
    return boxes;
  }
  std::size_t table_bytes() const override { return tables_.luma.bytes() + tables_.chroma.bytes(); }

 protected:
  const Tables tables_;
  WorkerPool& pool_;
  const NativeLayout layout_;
  NativeViews views_;
  const BandTiles<Luma> luma_;
  const BandTiles<Chroma> chroma_;
  const YuvRows& rows_;
  void (*finish_)() noexcept;  // after the last row that a task stores
  PerThread<Stages> stages_;
};

class Nv12Warp final : public TwoTableWarp<MutableNativeImage> {
 public:
  using TwoTableWarp::TwoTableWarp;

  WarpWork warp_changed(std::span<const NativeImage> faces, unsigned changed,
                        const MutableNativeImage& frame) noexcept override {
    assert(frame.layout == NativeLayout::kNv12 && frame.size == tables_.luma.frame);
    views_.set(faces);
    const ReflectedViews luma_views = views_.luma(tables_.luma);
    const ReflectedViews chroma_views = views_.chroma(tables_.chroma);
    const std::uint8_t black = black_luma(faces.front().colour.range);
    const int luma_bands = tables_.luma.tiles_down;
    WorkSum sum;
    pool_.run(luma_bands + tables_.chroma.tiles_down, [&](int task) {
      stages_.with_one([&](Stages& stages) {
        if (task < luma_bands) {
          sum.add(warp_luma(task, luma_views, changed, black, stages.luma, frame));
        } else {
          sum.add(warp_chroma(task - luma_bands, chroma_views, changed, stages.chroma, frame));
        }
        finish_();
      });
    });
    return sum.total();
  }

 private:
  WarpWork warp_luma(int band, const ReflectedViews& views, unsigned changed, std::uint8_t black,
                     Stage<Luma>& stage, const MutableNativeImage& frame) const {
    const WarpWork work = luma_.warp(band, views, {}, stage, [&](std::size_t tile) {
      return wanted_images(luma_reads_[tile], changed, luma_.images_share());
    });
    luma_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
      rows_.luma(stage.row(row, mirrored) + x, count, black, frame.planes[0].row(y) + x);
    });
    return work;
  }
  WarpWork warp_chroma(int band, const ReflectedViews& views, unsigned changed, Stage<Chroma>& stage,
                       const MutableNativeImage& frame) const {
    const WarpWork work = chroma_.warp(band, views, {}, stage, [&](std::size_t tile) {
      return wanted_images(chroma_reads_[tile], changed, chroma_.images_share());
    });
    chroma_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
      rows_.chroma(stage.row(row, mirrored) + x, count, frame.planes[1].row(y) + 2 * x);
    });
    return work;
  }

  const ViewsRead luma_reads_ = views_read(tables_.luma, luma_);
  const ViewsRead chroma_reads_ = views_read(tables_.chroma, chroma_);
};

class XrgbWarp final : public TwoTableWarp<MutableImage> {
 public:
  XrgbWarp(const Rig& rig, Tables tables, NativeLayout layout, Cpu cpu, WorkerPool& pool)
      : TwoTableWarp(rig, std::move(tables), layout, cpu, pool),
        bits_(sample_bytes(layout) == 2 ? 10 : 8),
        dither_(bits_ > 8 && rig.samples.dither) {}

  WarpWork warp_changed(std::span<const NativeImage> faces, unsigned changed,
                        const MutableImage& frame) noexcept override {
    assert(frame.format == PixelFormat::kXrgb8888 && frame.size == tables_.luma.frame);
    views_.set(faces);
    const ReflectedViews luma_views = views_.luma(tables_.luma);
    const ReflectedViews chroma_views = views_.chroma(tables_.chroma);
    const YuvToRgb matrix = yuv_to_rgb(faces.front().colour, {}, bits_);
    if (stale_) make_matrices(faces.front().colour);
    const auto wanted = [&](std::size_t tile) {
      return wanted_images(reads_[tile], changed, luma_.images_share());
    };
    WorkSum sum;
    pool_.run(tables_.luma.tiles_down, [&](int band) {
      stages_.with_one([&](Stages& stages) {
        sum.add(luma_.warp(band, luma_views, {}, stages.luma, wanted));
        chroma_.warp(band, chroma_views, {}, stages.chroma, wanted);
        luma_.unload(band, stages.luma, [&](int x, int y, int count, int row, bool mirrored) {
          const Luma* luma = stages.luma.row(row, mirrored);
          const Chroma* chroma = stages.chroma.row(row, mirrored);
          Xrgb* to = frame.samples<Xrgb>(0, y);
          const auto convert = [&](int first, int many, const YuvToRgb& by) {
            if (dither_)
              return rows_.xrgb_dithered(luma + first, chroma + first, many, by, first, y, to + first);
            rows_.xrgb(luma + first, chroma + first, many, by, to + first);
          };
          if (matrices_.empty()) return convert(x, count, matrix);
          mix_->for_each(x, y, count, [&](int first, int many, std::size_t kind) {
            convert(first, many, matrices_[kind]);
          });
        });
        chroma_.unload(band, stages.chroma, [](int, int, int, int, bool) {});
        finish_();
      });
    });
    return sum.total();
  }

  bool prepare_colours(const Rig& rig) override {
    mix_.emplace(rig, pool_);
    matrices_.resize(mix_->kinds());
    colours_.resize(rig.views.size());
    stale_ = true;
    return true;
  }
  void set_colours(std::span<const ViewColour> colours) noexcept override {
    assert(colours.size() == colours_.size());
    std::copy(colours.begin(), colours.end(), colours_.begin());
    stale_ = true;
  }

 private:
  void make_matrices(YuvColour colour) noexcept {
    for (std::size_t kind = 0; kind < matrices_.size(); ++kind)
      matrices_[kind] = yuv_to_rgb(colour, mix_->colour(kind, colours_), bits_);
    stale_ = false;
  }

  // A pixel is made of both: the tables' tiles are the same, and either is done where the other is.
  static ViewsRead of_both(ViewsRead luma, const ViewsRead& chroma) {
    assert(luma.size() == chroma.size());
    for (std::size_t tile = 0; tile < luma.size(); ++tile) {
      for (std::size_t image = 0; image < 4; ++image) luma[tile][image] |= chroma[tile][image];
    }
    return luma;
  }

  const int bits_;  // of a sample
  const bool dither_;
  std::optional<ViewMix> mix_;      // none: the views' own colours
  std::vector<YuvToRgb> matrices_;  // by the mix's kinds
  std::vector<ViewColour> colours_;
  bool stale_ = false;  // the matrices are of other colours
  const ViewsRead reads_ = of_both(views_read(tables_.luma, luma_), views_read(tables_.chroma, chroma_));
};

}  // namespace

std::unique_ptr<NativeWarp<MutableNativeImage>> make_nv12_warp(const Rig& rig, NativeLayout faces, Cpu cpu,
                                                               WorkerPool& pool, TableCache* cache) {
  if (is_rgb(faces) || sample_bytes(faces) > 1)
    throw InputError("frames of NV12 are made of YUV pictures of 8 bits, not of RGB or P010");
  Tables tables{table_of(rig, pool, cache), table_of(half_frame_chroma_rig(rig, faces), pool, cache)};
  return std::make_unique<Nv12Warp>(rig, std::move(tables), faces, cpu, pool);
}

std::unique_ptr<NativeWarp<MutableImage>> make_yuv_to_xrgb_warp(const Rig& rig, NativeLayout faces, Cpu cpu,
                                                                WorkerPool& pool, TableCache* cache) {
  Rig luma = rig;
  if (sample_bytes(faces) > 1) luma.filter.table = TableForm::kPrecise;
  return std::make_unique<XrgbWarp>(rig, tables_in_step(luma, chroma_rig(luma, faces), pool, cache), faces,
                                    cpu, pool);
}

}  // namespace cupola
