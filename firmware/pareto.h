// Time against error: which ways to make a frame are worth having, as a table and as a plot.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cupola {

struct ParetoMark {
  std::string name;
  double ns_per_pixel = 0.0;  // in-image pixels, one core
  double error = 0.0;         // RMS against the truth, 8-bit steps
  bool peer = false;          // somebody else's
  bool frontier = false;      // nothing of ours is both faster and truer
};

// One of the plot's parts: what is compared with each other.
struct ParetoPanel {
  std::string title;
  std::vector<ParetoMark> marks;
};

// Sets `frontier`; peers do not take part.
void find_frontier(std::vector<ParetoMark>& marks);

// Writes `file` with the extensions svg and png. False when the program was built without cairo, which draws
// them. Throws Failure.
bool draw_pareto(std::span<const ParetoPanel> panels, const std::filesystem::path& file);

}  // namespace cupola
