// Choosing a connector and a mode as an operator would.
// SPDX-License-Identifier: MIT
#include "hal/display/kms_mode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cupola {
namespace {

using testing::HasSubstr;
using testing::Not;

KmsMode mode(int width, int height, double rate, bool preferred = false) {
  return {width, height, std::chrono::nanoseconds(std::llround(1e9 / rate)), preferred, true};
}

KmsConnector projector() {
  KmsConnector connector{
      "HDMI-A-1",
      40,
      true,
      {mode(1920, 1200, 59.95, true), mode(1920, 1080, 60.0), mode(1920, 1080, 59.94), mode(1920, 1080, 50.0),
       mode(3840, 2160, 30.0), mode(1920, 1080, 60.0), mode(640, 480, 59.94)}};
  connector.modes[5].progressive = false;
  return connector;
}

std::string chosen(const char* wish, int width = 640, int height = 480) {
  const KmsConnector connector = projector();
  const KmsModeChoice choice = choose_kms_mode(connector.modes, *parse_kms_mode(wish), width, height);
  return describe(choice, connector, *parse_kms_mode(wish), width, height);
}

TEST(KmsMode, ReadsModesAsOperatorsWriteThem) {
  const auto whole = parse_kms_mode("1920x1200@59.94");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->width, 1920);
  EXPECT_EQ(whole->height, 1200);
  EXPECT_DOUBLE_EQ(whole->rate, 59.94);
  EXPECT_EQ(parse_kms_mode("1920x1200")->rate, 0.0);
  EXPECT_EQ(parse_kms_mode("")->width, 0);
  for (const char* text : {"1920", "1920x", "x1200", "1920x1200@", "1920x1200@60i", "-1x2", "1920 x 1200",
                           "1920x1200@nan", "1920x1200@-60", "0x0", "99999x1", "preferred"}) {
    EXPECT_FALSE(parse_kms_mode(text)) << text;
  }
}

TEST(KmsMode, IsTheProjectorsOwnUnlessAnotherIsAskedFor) {
  EXPECT_EQ(chosen(""), "HDMI-A-1 takes 1920x1200@59.95");
  EXPECT_EQ(chosen("1920x1200@60"), "HDMI-A-1 takes 1920x1200@59.95");
  EXPECT_EQ(chosen("640x480"), "HDMI-A-1 takes 640x480@59.94");
}

TEST(KmsMode, KeepsApartRatesThatAreNearlyTheSame) {
  EXPECT_EQ(chosen("1920x1080@60"), "HDMI-A-1 takes 1920x1080@60.00");
  EXPECT_EQ(chosen("1920x1080@59.94"), "HDMI-A-1 takes 1920x1080@59.94");
  EXPECT_EQ(chosen("1920x1080@50"), "HDMI-A-1 takes 1920x1080@50.00");
  EXPECT_EQ(chosen("1920x1080"), "HDMI-A-1 takes 1920x1080@60.00") << "the highest";
}

TEST(KmsMode, IsTheLargestWhereTheProjectorPrefersNone) {
  const KmsMode modes[] = {mode(800, 600, 60), mode(1024, 768, 60), mode(1024, 768, 75), mode(640, 480, 90)};
  EXPECT_EQ(choose_kms_mode(modes, {}, 1, 1).index, 2U);
}

TEST(KmsMode, IsNeverInterlaced) {
  KmsMode modes[] = {mode(1920, 1080, 60)};
  EXPECT_EQ(choose_kms_mode(modes, {}, 1, 1).trouble, KmsModeTrouble::kNone);
  modes[0].progressive = false;
  EXPECT_EQ(choose_kms_mode(modes, {}, 1, 1).trouble, KmsModeTrouble::kNoSuchMode);
}

TEST(KmsMode, ThatIsNotThereIsRefusedWithThoseThatAre) {
  const std::string refusal = chosen("1920x1200@75");
  EXPECT_THAT(refusal,
              HasSubstr("HDMI-A-1 has no mode 1920x1200@75; it has 1920x1200@59.95, 1920x1080@60.00, "));
  EXPECT_THAT(refusal, HasSubstr("3840x2160@30.00"));
  EXPECT_EQ(choose_kms_mode({}, {}, 1, 1).trouble, KmsModeTrouble::kNoModes);
}

TEST(KmsMode, HasToHoldTheFrame) {
  EXPECT_EQ(chosen("", 1920, 1200), "HDMI-A-1 takes 1920x1200@59.95");
  const std::string refusal = chosen("", 2048, 2048);
  EXPECT_THAT(refusal,
              HasSubstr("the frame of 2048x2048 is larger than the mode 1920x1200@59.95 of HDMI-A-1"));
  EXPECT_THAT(refusal, HasSubstr("these are large enough: 3840x2160@30.00"));
  EXPECT_THAT(chosen("", 1920, 1201), Not(HasSubstr("takes")));
  EXPECT_THAT(chosen("", 4096, 4096), HasSubstr("no other is large enough"));
}

TEST(KmsConnector, IsTheFirstWithAProjectorUnlessItIsNamed) {
  const KmsConnector connectors[] = {
      {"DP-1", 1, false, {}}, {"HDMI-A-1", 2, true, {}}, {"HDMI-A-2", 3, true, {}}};
  EXPECT_EQ(choose_kms_connector(connectors, ""), 1U);
  EXPECT_EQ(choose_kms_connector(connectors, "HDMI-A-2"), 2U);
  EXPECT_EQ(choose_kms_connector(connectors, "DP-1"), 0U) << "named: it may be plugged in later";
  EXPECT_EQ(choose_kms_connector(connectors, "HDMI-A"), std::nullopt);
  EXPECT_EQ(choose_kms_connector({}, ""), std::nullopt);
}

}  // namespace
}  // namespace cupola
