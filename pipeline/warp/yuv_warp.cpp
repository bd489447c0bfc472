// Two tables at work on one frame.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/yuv_warp.h"

#include <cassert>

#include "pipeline/warp/band_run.h"
#include "pipeline/warp/symmetry.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/yuv_rig.h"
#include "pipeline/warp/yuv_rows.h"
#include "pipeline/warp/yuv_views.h"

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

// Tables whose bands and mirror images are the same.
Tables tables_in_step(const Rig& luma, const Rig& chroma, WorkerPool& pool) {
  std::vector<Reflection> shared;
  const std::vector<Reflection> of_chroma = find_reflections(chroma);
  for (const Reflection& reflection : find_reflections(luma)) {
    for (const Reflection& other : of_chroma) {
      if (same(reflection, other)) shared.push_back(reflection);
    }
  }
  return {build_warp_table(luma, shared, pool), build_warp_table(chroma, shared, pool)};
}

std::vector<Size> view_sizes(const Rig& rig) {
  std::vector<Size> sizes;
  for (const View& view : rig.views) sizes.push_back(view.size);
  return sizes;
}

template <class Frame>
class TwoTableWarp : public YuvWarp<Frame> {
 public:
  TwoTableWarp(const Rig& rig, Tables tables, YuvLayout layout, Cpu cpu, WorkerPool& pool)
      : tables_(std::move(tables)),
        pool_(pool),
        views_(layout, view_sizes(rig)),
        luma_(tables_.luma, luma_kernel(cpu, luma_step(layout))),
        chroma_(tables_.chroma, chroma_kernel(cpu, chroma_step(layout))),
        rows_(yuv_rows(cpu)),
        finish_(row_store(cpu).finish),
        stages_(pool.threads(), [this] {
          return Stages{Stage<Luma>(tables_.luma), Stage<Chroma>(tables_.chroma)};
        }) {}

  std::size_t table_bytes() const override { return tables_.luma.bytes() + tables_.chroma.bytes(); }

 protected:
  const Tables tables_;
  WorkerPool& pool_;
  YuvViews views_;
  const BandTiles<Luma> luma_;
  const BandTiles<Chroma> chroma_;
  const YuvRows& rows_;
  void (*finish_)() noexcept;  // after the last row that a task stores
  PerThread<Stages> stages_;
};

class Nv12Warp final : public TwoTableWarp<MutableYuvImage> {
 public:
  using TwoTableWarp::TwoTableWarp;

  void warp(std::span<const YuvImage> faces, const MutableYuvImage& frame) noexcept override {
    assert(frame.layout == YuvLayout::kNv12 && frame.size == tables_.luma.frame);
    views_.set(faces);
    const ReflectedViews luma_views = views_.luma(tables_.luma);
    const ReflectedViews chroma_views = views_.chroma(tables_.chroma);
    const std::uint8_t black = black_luma(faces.front().colour.range);
    const int luma_bands = tables_.luma.tiles_down;
    pool_.run(luma_bands + tables_.chroma.tiles_down, [&](int task) {
      stages_.with_one([&](Stages& stages) {
        if (task < luma_bands) {
          warp_luma(task, luma_views, black, stages.luma, frame);
        } else {
          warp_chroma(task - luma_bands, chroma_views, stages.chroma, frame);
        }
        finish_();
      });
    });
  }

 private:
  void warp_luma(int band, const ReflectedViews& views, std::uint8_t black, Stage<Luma>& stage,
                 const MutableYuvImage& frame) const {
    luma_.warp(band, views, {}, stage);
    luma_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
      rows_.luma(stage.row(row, mirrored) + x, count, black, frame.planes[0].row(y) + x);
    });
  }
  void warp_chroma(int band, const ReflectedViews& views, Stage<Chroma>& stage,
                   const MutableYuvImage& frame) const {
    chroma_.warp(band, views, {}, stage);
    chroma_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
      rows_.chroma(stage.row(row, mirrored) + x, count, frame.planes[1].row(y) + 2 * x);
    });
  }
};

class XrgbWarp final : public TwoTableWarp<MutableImage> {
 public:
  using TwoTableWarp::TwoTableWarp;

  void warp(std::span<const YuvImage> faces, const MutableImage& frame) noexcept override {
    assert(frame.format == PixelFormat::kXrgb8888 && frame.size == tables_.luma.frame);
    views_.set(faces);
    const ReflectedViews luma_views = views_.luma(tables_.luma);
    const ReflectedViews chroma_views = views_.chroma(tables_.chroma);
    const YuvToRgb matrix = yuv_to_rgb(faces.front().colour);
    pool_.run(tables_.luma.tiles_down, [&](int band) {
      stages_.with_one([&](Stages& stages) {
        luma_.warp(band, luma_views, {}, stages.luma);
        chroma_.warp(band, chroma_views, {}, stages.chroma);
        luma_.unload(band, stages.luma, [&](int x, int y, int count, int row, bool mirrored) {
          rows_.xrgb(stages.luma.row(row, mirrored) + x, stages.chroma.row(row, mirrored) + x, count, matrix,
                     frame.samples<Xrgb>(0, y) + x);
        });
        chroma_.unload(band, stages.chroma, [](int, int, int, int, bool) {});
        finish_();
      });
    });
  }
};

}  // namespace

std::unique_ptr<YuvWarp<MutableYuvImage>> make_nv12_warp(const Rig& rig, YuvLayout faces, Cpu cpu,
                                                         WorkerPool& pool) {
  Tables tables{build_warp_table(rig, pool), build_warp_table(half_frame_chroma_rig(rig, faces), pool)};
  return std::make_unique<Nv12Warp>(rig, std::move(tables), faces, cpu, pool);
}

std::unique_ptr<YuvWarp<MutableImage>> make_yuv_to_xrgb_warp(const Rig& rig, YuvLayout faces, Cpu cpu,
                                                             WorkerPool& pool) {
  return std::make_unique<XrgbWarp>(rig, tables_in_step(rig, chroma_rig(rig, faces), pool), faces, cpu, pool);
}

}  // namespace cupola
