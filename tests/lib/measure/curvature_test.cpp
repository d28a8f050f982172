// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <mapjoin/measure/curvature.hpp>
#include <numbers>
#include <stdexcept>

namespace mapjoin {
namespace {

CurvatureFigures figures_of(const std::function<double(double)>& F) {
  return curvature_figures(sampled(F, 101));
}

TEST(Curvature, SamplesFromEndToEnd) {
  const auto values = sampled([](double lambda) { return 3.0 * lambda; }, 4);
  ASSERT_EQ(values.size(), 4u);
  EXPECT_EQ(values.front(), 0.0);
  EXPECT_DOUBLE_EQ(values[1], 1.0);
  EXPECT_EQ(values.back(), 3.0);
  EXPECT_THROW(sampled([](double) { return 0.0; }, 2), std::invalid_argument);
}

TEST(Curvature, OfAParabolaSpeaksForConvexity) {
  const auto figures = figures_of([](double x) { return 5e8 * (x - 0.3) * (x - 0.3) + 7.0; });
  EXPECT_EQ(figures.points, 99u);
  EXPECT_EQ(figures.violations, 0u);
  EXPECT_EQ(figures.negative, 0u);
  EXPECT_EQ(figures.largest_violation, 0.0);
}

TEST(Curvature, OfAStraightOrConstantFunctionSpeaksForConvexity) {
  for (const double slope : {0.0, 1.0, -1e10}) {
    const auto figures = figures_of([&](double x) { return slope * x + 0.1; });
    EXPECT_EQ(figures.violations + figures.negative, 0u) << slope;
  }
  EXPECT_EQ(figures_of([](double) { return 0.0; }).violations, 0u);
}

TEST(Curvature, OfADomeViolatesEverywhere) {
  const auto figures = figures_of([](double x) { return 2.0 + x * (1.0 - x); });
  EXPECT_EQ(figures.share_violated(), 1.0);
  EXPECT_EQ(figures.share_negative(), 1.0);
  EXPECT_NEAR(figures.largest_violation, 0.125, 1e-12);  // 1/4 above a chord of height 2
}

TEST(Curvature, OfACosineIsNegativeWhereTheCosineIsPositive) {
  const auto figures = figures_of([](double x) { return 10.0 + std::cos(2.0 * std::numbers::pi * x); });
  EXPECT_EQ(figures.violations, 0u);  // a cosine that begins and ends at its maximum never exceeds the chord
  EXPECT_NEAR(figures.share_negative(), 0.5, 0.02);
}

TEST(Curvature, IsTheSameHoweverManySamples) {
  for (const std::size_t points : {101u, 1001u, 100'001u}) {
    const auto values = sampled([](double x) { return 10.0 + 0.1 * std::cos(2.0 * std::numbers::pi * x); }, points);
    EXPECT_NEAR(curvature_figures(values).share_negative(), 0.5, 0.02) << points;
  }
}

TEST(Curvature, AllowsForRounding) {
  const auto rough = [](double noise) { return figures_of([=](double x) { return 1.0 + x + noise * std::sin(1e4 * x); }); };
  EXPECT_EQ(rough(1e-12).negative, 0u);
  EXPECT_GT(rough(1e-8).negative, 20u);
  // A second difference below -1e-10 of the largest value is told from rounding; here it is twice the depth.
  for (const auto& [depth, is_told] : {std::pair{0.4e-10, false}, {0.6e-10, true}}) {
    EXPECT_EQ(curvature_figures({1.0, 1.0 + depth, 1.0}).negative, is_told ? 1u : 0u) << depth;
  }
}

TEST(Curvature, TakesWhatIsNotFiniteForAViolation) {
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const auto figures = curvature_figures({1.0, 0.5, bad, 0.5, 1.0});
    EXPECT_EQ(figures.violations, 1u);
  }
  EXPECT_EQ(curvature_figures({1.0, 2.0}).points, 0u);
}

TEST(Curvature, AddsUpOverSegments) {
  auto figures = figures_of([](double x) { return x * x; });
  figures.add(figures_of([](double x) { return 1.0 - x * x; }));
  EXPECT_EQ(figures.points, 198u);
  EXPECT_DOUBLE_EQ(figures.share_negative(), 0.5);
  EXPECT_NEAR(figures.largest_violation, 0.25, 1e-3);
}

}  // namespace
}  // namespace mapjoin
