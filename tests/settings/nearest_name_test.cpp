// Which known name a typing error is taken for.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

constexpr std::string_view kNames[] = {"lens", "frame", "filter", "view", "tilt_deg", "file"};

TEST(NearestName, FindsTheNameAFewEditsAway) {
  EXPECT_EQ(nearest_name("lense", kNames), "lens");
  EXPECT_EQ(nearest_name("tiltdeg", kNames), "tilt_deg");
  EXPECT_EQ(nearest_name("veiw", kNames), "view");
}

TEST(NearestName, FindsNothingWhereNoneIsNear) {
  EXPECT_EQ(nearest_name("projector", kNames), "");
  EXPECT_EQ(nearest_name("", kNames), "");
  EXPECT_EQ(nearest_name("lens", {}), "");
}

TEST(NearestName, TakesTheEarlierOfTwoEquallyNear) {
  constexpr std::string_view names[] = {"left", "lift"};
  EXPECT_EQ(nearest_name("lxft", names), "left");
}

TEST(NearestName, DoesNotStumbleOverVeryLongWords) {
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'x'), kNames), "");
}

}  // namespace
}  // namespace cupola
