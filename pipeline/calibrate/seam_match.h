// How far apart two cameras show the same things where their views meet, measured in their pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/frame/grey_picture.h"
#include "pipeline/optics/rig.h"

namespace cupola {

// One place of a seam.
struct SeamShift {
  Vec2 at;     // texels of the second view
  Vec2 apart;  // from there to where, through the rig, the first view shows what the second has at `at`
};

struct SeamMeasure {
  static constexpr std::size_t kLeast = 8;  // shifts, to say anything of a seam

  std::vector<SeamShift> shifts;  // of the places that told one; of several looks at a place the median
  // The places that told none, by why: too little texture, or none that is sure to be more than noise; the
  // same pattern twice in reach; nothing alike in reach.
  std::size_t plain = 0;
  std::size_t repeating = 0;
  std::size_t unlike = 0;
  // Of the shifts, those far from what most are: things nearer or farther than the others, and things that
  // moved. What follows is about the rest, in texels of the second view.
  std::size_t strays = 0;
  double median = 0.0;  // length
  double most = 0.0;    // 95 % are no longer
  Vec2 mostly{0.0};     // medians of u and of v

  std::size_t places() const { return shifts.size() + plain + repeating + unlike; }
  // Whether the shifts are enough, and no accidents among places that do not agree.
  bool tells() const { return shifts.size() >= kLeast && 2 * shifts.size() >= unlike; }
};

// The mathematics are in docs/calibration.md. One thread.
class SeamMatch {
 public:
  static constexpr int kPatch = 17;  // texels, a side
  static constexpr int kReach = 12;  // texels: longer shifts are not found
  static constexpr std::size_t kMostPlaces = 128;

  // Two different views of the rig, both with sizes.
  SeamMatch(const Rig& rig, std::size_t first, std::size_t second);

  // Whether the views overlap near a seam of the frame, by as much as a patch and the reach about it.
  bool overlap() const { return !places_.empty(); }
  // Both views' pictures of one instant, of their sizes. Of several looks a place has the median.
  void look(const GreyPicture& first, const GreyPicture& second);
  SeamMeasure measure() const;

 private:
  struct Place {
    int x = 0, y = 0;            // the patch's corner in the second view
    std::vector<Vec2> in_first;  // where the first view sees the texels of the patch and the reach about it
    std::vector<Vec2> shifts;    // found so far
    bool repeats = false;        // in some look
    bool unlike = false;
  };
  void match(Place& place, const std::vector<float>& first, const std::vector<float>& second) const;

  Size first_size_;
  Size second_size_;
  std::vector<Place> places_;
};

}  // namespace cupola
