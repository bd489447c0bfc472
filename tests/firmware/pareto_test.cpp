// The frontier of time against error, and that the plot is a picture.
// SPDX-License-Identifier: MIT
#include "firmware/pareto.h"

#include <gtest/gtest.h>

#include "pipeline/frame/still.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

std::vector<ParetoMark> some_marks() {
  return {{"slow, true", 40.0, 1.0}, {"quick", 1.0, 9.0},  {"between", 4.0, 3.0},
          {"beaten", 5.0, 3.5},      {"as slow", 40.0, 2}, {"peer", 0.5, 0.5, true}};
}

TEST(Pareto, FrontierIsWhatNothingOfOursBeatsInBoth) {
  std::vector<ParetoMark> marks = some_marks();
  find_frontier(marks);
  std::vector<std::string> names;
  for (const ParetoMark& mark : marks) {
    if (mark.frontier) names.push_back(mark.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"slow, true", "quick", "between"}));
}

TEST(Pareto, PlotsOpenAsPictures) {
  const TemporaryFolder folder;
  std::vector<ParetoMark> marks = some_marks();
  find_frontier(marks);
  const std::vector<ParetoPanel> panels = {{"1 : 1", marks}, {"2 : 1", marks}};
  if (!draw_pareto(panels, folder / "plot")) {
    EXPECT_FALSE(std::filesystem::exists(folder / "plot.png"));
    return;
  }
  const ImageBuffer plot = read_still(folder / "plot.png");
  EXPECT_EQ(plot.size(), (Size{1240, 560}));
  EXPECT_GT(std::filesystem::file_size(folder / "plot.svg"), 1000U);
}

}  // namespace
}  // namespace cupola
