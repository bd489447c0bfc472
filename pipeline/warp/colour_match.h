// One picture from several sensors: gains and offsets of every view, found where pictures overlap.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/frame/native_image.h"
#include "pipeline/optics/rig.h"
#include "pipeline/warp/view_colour.h"

namespace cupola {

// The mathematics are in docs/warp.md. One thread; after construction it allocates nothing. A call to look()
// reads kSamplesALook patches of two pictures, or solves for one channel.
class ColourMatch {
 public:
  static constexpr int kPatch = 8;                 // texels of luma, a side
  static constexpr std::size_t kMostSamples = 64;  // of a pair of views
  static constexpr std::size_t kSamplesALook = 8;

  // The rig's views have sizes; faces are YUV of this layout and colour. Views with a locked colour keep it,
  // and the others go by them.
  ColourMatch(const Rig& rig, NativeLayout layout, YuvColour colour,
              std::span<const std::optional<ViewColour>> locked);

  // How many pairs of views overlap by enough, near the seams: without any there is nothing to match.
  std::size_t pairs() const { return pairs_; }
  // What is read of a view's picture; empty: nothing.
  TexelBox reads(std::size_t view) const { return reads_[view]; }

  // A new set of faces, at `now`. Bit v of `seen`: view v shows its camera's picture of this set. True when
  // colours() are others than before.
  bool look(std::span<const NativeImage> faces, unsigned seen, std::chrono::nanoseconds now) noexcept;
  std::span<const ViewColour> colours() const { return applied_; }

 private:
  struct Patch {
    std::uint16_t view = 0;
    int x = 0, y = 0;
  };
  struct Sample {
    std::array<Patch, 2> at;
    std::array<std::array<double, 3>, 2> rgb{};
    std::uint16_t pair = 0;
    bool good = false;  // in this round
  };

  void find_samples(const Rig& rig);
  void measure(Sample& sample, std::span<const NativeImage> faces, unsigned seen) const noexcept;
  bool mean(const NativeImage& face, const Patch& patch, std::array<double, 3>& rgb) const noexcept;
  void weigh(std::size_t channel) noexcept;
  void solve(std::size_t channel, double share) noexcept;
  bool apply() noexcept;

  NativeLayout layout_;
  YuvColour colour_;
  std::vector<bool> locked_;
  std::vector<Sample> samples_;  // pair by pair
  std::size_t pairs_ = 0;
  std::vector<TexelBox> reads_;
  std::vector<double> weights_;  // of the samples, for the channel at hand
  std::vector<ViewColour> now_;  // as they are followed
  std::vector<ViewColour> applied_;
  std::vector<std::array<bool, 3>> moving_;  // past the dead band and not yet there
  std::size_t next_ = 0;                     // the sample or, past them, the channel that comes next
  std::chrono::nanoseconds solved_at_{0};
};

}  // namespace cupola
