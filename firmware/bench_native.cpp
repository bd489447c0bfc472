// Noise in every plane.
// SPDX-License-Identifier: MIT
#include "firmware/bench_native.h"

#include <random>

#include "pipeline/warp/ewa_warp.h"

namespace cupola {
namespace {

NativeBuffer noise(NativeLayout layout, Size size, std::mt19937& random) {
  NativeBuffer buffer(layout, {}, size);
  for (std::size_t p = 0; p < plane_count(layout); ++p) {
    const Size bytes = plane_bytes(layout, size, p);
    for (int y = 0; y < bytes.height; ++y) {
      for (int x = 0; x < bytes.width; ++x) {
        buffer.pixels().planes[p].row(y)[x] = static_cast<std::uint8_t>(random() >> 24);
      }
    }
  }
  return buffer;
}

}  // namespace

NativeBench::NativeBench(const Rig& rig, const WarpTable& table, std::span<const Image> faces,
                         WorkerPool& alone, Cpu cpu)
    : cpu_(cpu),
      rgb_(faces),
      in_image_(static_cast<double>(table.pixels_in_image)),
      xrgb_(PixelFormat::kXrgb8888, rig.frame.size),
      frame_(NativeLayout::kNv12, {}, rig.frame.size),
      rgb_to_xrgb_(make_table_warp(table, cpu, alone)),
      nv12_to_nv12_(make_nv12_warp(rig, NativeLayout::kNv12, cpu, alone)),
      nv12_to_xrgb_(make_native_to_xrgb_warp(rig, NativeLayout::kNv12, cpu, alone)),
      p010_to_xrgb_(make_native_to_xrgb_warp(rig, NativeLayout::kP010, cpu, alone)),
      yuyv_to_xrgb_(make_native_to_xrgb_warp(rig, NativeLayout::kYuyv, cpu, alone)),
      rgb24_to_xrgb_(make_native_to_xrgb_warp(rig, NativeLayout::kRgb24, cpu, alone)),
      xrgb32_to_xrgb_(make_native_to_xrgb_warp(rig, NativeLayout::kXrgb32, cpu, alone)) {
  std::mt19937 random(1);
  const auto fill = [&](std::vector<NativeImage>& images, NativeLayout layout) {
    for (const View& view : rig.views) {
      buffers_.push_back(noise(layout, view.size, random));
      images.push_back(as_const(buffers_.back().pixels()));
    }
  };
  fill(nv12_, NativeLayout::kNv12);
  fill(p010_, NativeLayout::kP010);
  fill(yuyv_, NativeLayout::kYuyv);
  fill(rgb24_, NativeLayout::kRgb24);
  fill(xrgb32_, NativeLayout::kXrgb32);
}

std::vector<Lap> NativeBench::laps() {
  const auto lap = [&](const char* name, std::size_t bytes, std::function<void()> work) {
    const std::string full = std::string(name) + ", " + std::string(cupola::name(cpu_));
    return Lap{{full, 0, 0, static_cast<double>(bytes) / in_image_, -1, -1}, std::move(work), {}};
  };
  return {lap("ewa fast to xrgb", rgb_to_xrgb_->table_bytes(),
              [this] { rgb_to_xrgb_->warp(rgb_, xrgb_.pixels()); }),
          lap("nv12 to nv12", nv12_to_nv12_->table_bytes(),
              [this] { nv12_to_nv12_->warp(nv12_, frame_.pixels()); }),
          lap("nv12 to xrgb", nv12_to_xrgb_->table_bytes(),
              [this] { nv12_to_xrgb_->warp(nv12_, xrgb_.pixels()); }),
          lap("p010 to xrgb", p010_to_xrgb_->table_bytes(),
              [this] { p010_to_xrgb_->warp(p010_, xrgb_.pixels()); }),
          lap("yuyv to xrgb", yuyv_to_xrgb_->table_bytes(),
              [this] { yuyv_to_xrgb_->warp(yuyv_, xrgb_.pixels()); }),
          lap("rgb24 to xrgb", rgb24_to_xrgb_->table_bytes(),
              [this] { rgb24_to_xrgb_->warp(rgb24_, xrgb_.pixels()); }),
          lap("xrgb32 to xrgb", xrgb32_to_xrgb_->table_bytes(),
              [this] { xrgb32_to_xrgb_->warp(xrgb32_, xrgb_.pixels()); })};
}

}  // namespace cupola
