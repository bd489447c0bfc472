// Lenses: the published figures, inverses, slopes, and the refusal of lenses that fold.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cupola {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Lens opencv() {
  return {LensModel::kOpencvFisheye, 95 * kDegree, {-0.02, 0.003, -0.0004, 0.00001}, "opencv"};
}

struct NamedLens {
  const char* name;
  Lens lens;
};

class EveryLens : public testing::TestWithParam<NamedLens> {};

TEST_P(EveryLens, BeginsOnTheAxisAndRises) {
  const Lens& lens = GetParam().lens;
  EXPECT_EQ(fault(lens), "");
  EXPECT_NEAR(sample(lens, 0.0).phi, 0.0, 1e-15);
  double before = 0.0;
  for (int i = 1; i <= 1000; ++i) {
    const double phi = sample(lens, i / 1000.0).phi;
    ASSERT_GT(phi, before);
    before = phi;
  }
}

TEST_P(EveryLens, SlopeIsTheDerivative) {
  const Lens& lens = GetParam().lens;
  constexpr double kStep = 1e-6;
  for (int i = 1; i < 990; ++i) {
    const double r = i / 1000.0;
    const double difference = (sample(lens, r + kStep).phi - sample(lens, r - kStep).phi) / (2 * kStep);
    ASSERT_NEAR(sample(lens, r).slope, difference, 1e-6 * std::max(1.0, difference)) << r;
  }
}

TEST_P(EveryLens, InverseComesBackToTheRadius) {
  const Lens& lens = GetParam().lens;
  for (int i = 0; i <= 1000; ++i) {
    const double r = i / 1000.0;
    // An orthographic lens turns infinitely fast at its rim, so that an angle tells little of the radius.
    const double bound = lens.model == LensModel::kOrthographic && i > 990 ? 1e-9 : 1e-13;
    ASSERT_NEAR(radius_at(lens, sample(lens, r).phi), r, bound);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Models, EveryLens,
    testing::Values(NamedLens{"c430", omnimax_c430()}, NamedLens{"equidistant", equidistant(180)},
                    NamedLens{"equidistant240", equidistant(240)},
                    NamedLens{"equisolid", {LensModel::kEquisolid, 90 * kDegree, {}, ""}},
                    NamedLens{"equisolid300", {LensModel::kEquisolid, 150 * kDegree, {}, ""}},
                    NamedLens{"stereographic", {LensModel::kStereographic, 90 * kDegree, {}, ""}},
                    NamedLens{"orthographic", {LensModel::kOrthographic, 90 * kDegree, {}, ""}},
                    NamedLens{"orthographic100", {LensModel::kOrthographic, 50 * kDegree, {}, ""}},
                    NamedLens{"polynomial", {LensModel::kPolynomial, 0, {0, 1.2, 0.1, 0.2}, ""}},
                    NamedLens{"opencv", opencv()}),
    [](const auto& instance) { return instance.param.name; });

TEST(Lens, OmnimaxRimIsAt90Point16Degrees) {
  EXPECT_NEAR(sample(omnimax_c430(), 1.0).phi / kDegree, 90.16, 0.005);
  EXPECT_DOUBLE_EQ(sample(omnimax_c430(), 1.0).phi, 1.411269 - 0.094389 + 0.25674);
}

TEST(Lens, NamedModelsFollowTheirFormulas) {
  const double r = 0.37;
  EXPECT_NEAR(sample({LensModel::kEquisolid, 90 * kDegree, {}, ""}, r).phi,
              2 * std::asin(r * std::sin(45 * kDegree)), 1e-14);
  EXPECT_NEAR(sample({LensModel::kStereographic, 90 * kDegree, {}, ""}, r).phi,
              2 * std::atan(r * std::tan(45 * kDegree)), 1e-14);
  EXPECT_NEAR(sample({LensModel::kOrthographic, 90 * kDegree, {}, ""}, r).phi, std::asin(r), 1e-14);
}

TEST(Lens, FoldIsRefusedWithItsRadius) {
  // phi = 2 r - r^3 stops rising at r = sqrt(2 / 3) = 0.816497.
  const std::string wrong = fault({LensModel::kPolynomial, 0, {0, 2, 0, -1}, ""});
  EXPECT_NE(wrong.find("folds"), std::string::npos);
  EXPECT_NE(wrong.find("0.816497"), std::string::npos) << wrong;
  EXPECT_NE(fault({LensModel::kOpencvFisheye, 90 * kDegree, {-0.3}, ""}).find("folds"), std::string::npos);
}

TEST(Lens, OtherFaultsAreNamed) {
  EXPECT_NE(fault({LensModel::kPolynomial, 0, {0.1, 1}, ""}), "");
  EXPECT_NE(fault({LensModel::kPolynomial, 0, {0, std::nan("")}, ""}), "");
  EXPECT_NE(fault({LensModel::kPolynomial, 0, {0, 4}, ""}), "") << "past the opposite direction";
  EXPECT_NE(fault({LensModel::kPolynomial, 0, {0, 0, 0}, ""}), "");
}

TEST(LensFault, NamesCoefficientsThatOverflow) {
  EXPECT_NE(fault({LensModel::kOpencvFisheye, 3.0, {1e308}, {}}), "");
  EXPECT_NE(fault({LensModel::kPolynomial, 0.0, {0.0, 1e308, 1e308}, {}}), "");
}

}  // namespace
}  // namespace cupola
