// Asks for the texels of the tile after the one at work, a row at a time: the processor cannot foresee them,
// and waiting for them costs a warp of one or two channels a quarter of its time.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {

class TexelsAhead {
 public:
  TexelsAhead() = default;
  // What `tile` reads of planes of `planes` channels for `images`, in `steps` steps.
  template <class Pixel>
  TexelsAhead(const WarpTable& table, const Tile& tile, const TileImage<Pixel>* images, int image_count,
              int planes, int steps) {
    int rows = 0;
    for (int i = 0; i < tile.reach_count; ++i) {
      const Reach& reach = table.reaches[tile.first_reach + static_cast<std::size_t>(i)];
      for (int image = 0; image < image_count; ++image) {
        const ViewTexels& view = images[image].views[reach.view];
        // Mirrored views run leftward.
        const int x = view.across > 0 ? reach.x0 : reach.x1 - kWindowSide;
        for (int plane = 0; plane < planes && count_ < parts_.size(); ++plane) {
          const std::uint8_t* first = view.window(x, reach.y0) + view.channel[plane];
          parts_[count_++] = {first, view.stride, reach.y1 - reach.y0,
                              static_cast<int>((reach.x1 - reach.x0) * view.step)};
          rows += reach.y1 - reach.y0;
        }
      }
    }
    rows_a_step_ = steps > 0 ? (rows + steps - 1) / steps : 0;
  }

  void step() {
    for (int i = 0; i < rows_a_step_; ++i) {
      if (row_.rows == 0) {
        if (next_ == count_) return;
        row_ = parts_[next_++];
      }
      constexpr int kLine = 64;
      for (int byte = 0; byte < row_.bytes; byte += kLine) __builtin_prefetch(row_.first + byte);
      row_.first += row_.stride;
      --row_.rows;
    }
  }

 private:
  struct Part {
    const std::uint8_t* first = nullptr;
    std::ptrdiff_t stride = 0;
    int rows = 0;
    int bytes = 0;
  };
  std::array<Part, 4 * kMostViews> parts_;
  std::size_t count_ = 0;
  std::size_t next_ = 0;
  Part row_;
  int rows_a_step_ = 0;
};

}  // namespace cupola
