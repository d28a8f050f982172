// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {
namespace {

/// Tests at evenly spread quantiles of chi-squared, scaled.
std::vector<PartTest> spread_tests(int count, double scale) {
  std::vector<PartTest> tests;
  for (int k = 0; k < count; ++k) tests.push_back({scale * chi_squared_quantile((k + 0.5) / count, 3), 3, 3.0});
  return tests;
}

TEST(ScaleTest, FindTheScaleOfCautiousCovariancesWithAMargin) {
  const double scale = scale_of(spread_tests(400, 0.1), 3);
  EXPECT_GT(scale, 0.1);
  EXPECT_LT(scale, 0.13);
}

TEST(ScaleTest, NeverJudgeMoreLenientlyThanCovariances) {
  EXPECT_EQ(scale_of(spread_tests(400, 5.0), 3), 1.0);
}

TEST(ScaleTest, BelieveNoScaleOfAFewTests) {
  EXPECT_EQ(scale_of(spread_tests(19, 0.1), 3), 1.0);
  EXPECT_LT(scale_of(spread_tests(20, 0.1), 3), 1.0);
}

}  // namespace
}  // namespace mapjoin
