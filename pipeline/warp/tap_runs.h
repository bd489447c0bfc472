// Any weights at all, executed as they are: per pixel a list of texel runs, each in some image.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/quantise.h"

namespace cupola {

// Weights of a pixel are 1 and more and sum to exactly 2^14; a pixel without runs is black.
struct TapRuns {
  static constexpr int kShift = 14;
  struct Run {
    std::uint16_t x, y;   // the first texel
    std::uint16_t count;  // texels to the right
    std::uint16_t image;
  };
  struct Start {  // of a pixel's runs and weights
    std::uint32_t run = 0;
    std::uint32_t weight = 0;
  };

  Size frame;
  std::vector<Start> starts;  // one a pixel, row by row, and one for the end
  std::vector<Run> runs;
  std::vector<std::uint16_t> weights;

  std::size_t bytes() const {
    return starts.size() * sizeof(Start) + runs.size() * sizeof(Run) + weights.size() * sizeof(weights[0]);
  }
  std::size_t taps() const { return weights.size(); }
};

// Appends one pixel; `taps` as quantise() takes them with `view` for the image; none for a black pixel.
void append_pixel(const std::vector<Tap>& taps, std::vector<int>& scratch, TapRuns& to);
// Appends the pixels of `part` to `whole`, and its end when all are there.
void append_rows(const TapRuns& part, TapRuns& whole);

// Calls pixel(x, y, taps), on several threads, for every pixel of the frame.
template <class Pixel>
TapRuns collect_tap_runs(Size frame, WorkerPool& pool, const Pixel& pixel) {
  std::vector<TapRuns> rows(static_cast<std::size_t>(frame.height));
  pool.run(frame.height, [&](int y) {
    std::vector<Tap> taps;
    std::vector<int> scratch;
    for (int x = 0; x < frame.width; ++x) {
      taps.clear();
      pixel(x, y, taps);
      append_pixel(taps, scratch, rows[static_cast<std::size_t>(y)]);
    }
  });
  TapRuns whole;
  whole.frame = frame;
  for (TapRuns& row : rows) {
    append_rows(row, whole);
    row = {};
  }
  whole.starts.push_back(
      {static_cast<std::uint32_t>(whole.runs.size()), static_cast<std::uint32_t>(whole.weights.size())});
  return whole;
}

}  // namespace cupola
