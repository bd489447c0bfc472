// Fits the two passes along one line of the frame.
//
// For that line and one line of texels, the weights that pixels p give to texels u are a matrix w(p, u). Two
// passes make it a product b(p) a(u): a is one sample of the first pass, b its share in the pixels. Lines of
// texels have nothing in common, so the best products line by line are the best whole.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/warp/footprint.h"
#include "pipeline/warp/rank_one.h"
#include "pipeline/warp/two_pass_plan.h"

namespace cupola {

struct Share {
  std::uint32_t pixel;   // of the frame
  std::uint32_t sample;  // of the line's
  double weight;
};

// All that one line of the frame adds to the plan.
struct LineResult {
  std::vector<TwoPassPlan::Sample> samples;
  std::vector<std::uint16_t> weights;
  std::vector<Share> shares;
};

// Of the sum of squares of all weights, and what their products miss.
struct Loss {
  double energy = 0.0, residual = 0.0;
};

class LineFitter {
 public:
  explicit LineFitter(const Rig& rig) : rig_(rig), gatherer_(rig) {}  // borrowed

  // The footprints of a column or row of the frame.
  void gather(bool column, int line);
  // What one sample a line of texels would lose, without parting.
  Loss loss(std::size_t view, bool along_rows);
  // Adds the view's samples, of texels along its rows or columns.
  void fit(std::size_t view, bool along_rows, LineResult& result);

 private:
  // One weight: of texel `along` in a line of a view for pixel `pixel` of the frame's line.
  struct Entry {
    std::int32_t line, along, pixel;
    double weight;
  };
  struct Footed {
    Tap tap;
    std::int32_t pixel;
  };
  struct Footing {
    double energy = 0.0;       // sum of the squares of all weights
    double least_share = 0.0;  // those below are left out
  };

  template <class Body>
  void for_each_line(std::size_t view, bool along_rows, const Body& body);
  const DenseMatrix& matrix(std::span<const Entry> line);
  void fit_part(const DenseMatrix& w, std::size_t first, std::size_t last, std::size_t view, bool along_rows,
                LineResult& result);
  void add_sample(std::size_t view, bool along_rows, LineResult& result);

  const Rig& rig_;
  FootprintGatherer gatherer_;
  bool column_ = false;
  int line_ = 0;
  std::vector<Footed> footprints_;
  std::vector<Footing> pixels_of_line_;
  // Of the line of texels at hand.
  std::vector<std::uint32_t> starts_;
  std::vector<Entry> sorted_;
  std::vector<std::int32_t> pixels_;
  DenseMatrix matrix_;
  int first_along_ = 0;
  int texel_line_ = 0;
  RankOne fit_;
  std::vector<Tap> taps_;
  std::vector<int> integers_;
};

}  // namespace cupola
