// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {
namespace {

TEST(NthLargest, IsPrecededBySoManyOthers) {
  const std::vector<double> values = {2.0, 5.0, -1.0, 5.0, 3.0};
  EXPECT_EQ(nth_largest(values, 0), 5.0);
  EXPECT_EQ(nth_largest(values, 1), 5.0);
  EXPECT_EQ(nth_largest(values, 2), 3.0);
  EXPECT_EQ(nth_largest(values, 4), -1.0);
}

TEST(WeightedMedian, IsWhereHalfOfTheWeightIsReached) {
  EXPECT_EQ(weighted_median({{3.0, 1.0}, {1.0, 1.0}, {2.0, 1.0}}), 2.0);
  EXPECT_EQ(weighted_median({{3.0, 2.5}, {1.0, 1.0}, {2.0, 1.0}}), 3.0);
  EXPECT_EQ(weighted_median({{3.0, 0.5}, {1.0, 0.25}, {2.0, 0.25}}), 2.0);
  EXPECT_EQ(weighted_median({{7.0, 0.0}}), 7.0);
}

TEST(WholePart, IsNotMissedByRounding) {
  EXPECT_EQ(whole_part(0.3 / 0.1), 3);
  EXPECT_EQ(whole_part((1.0 - 0.9) * 10.0), 1);
  EXPECT_EQ(whole_part(2.999), 2);
  EXPECT_EQ(whole_part(0.0), 0);
  EXPECT_TRUE(is_whole(0.3 / 0.1));
  EXPECT_FALSE(is_whole(2.999));
}

TEST(ChiSquared, IsNeverBeyondAllNumbers) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(chi_squared_upper_tail(infinite, 3), 0.0);
  EXPECT_LT(log_chi_squared_upper_tail(infinite, 3), log_chi_squared_upper_tail(1e300, 3));
}

TEST(ChiSquared, OfNoNumberHasNoProbability) {
  for (const double dof : {0.0, 3.0}) {
    EXPECT_TRUE(std::isnan(chi_squared_upper_tail(std::nan(""), dof)));
    EXPECT_TRUE(std::isnan(log_chi_squared_upper_tail(std::nan(""), dof)));
  }
}

TEST(ChiSquared, OfNearlyNothingIsCertainWithAnyDegreesOfFreedom) {
  for (const double value : {0.0, 5e-324, 1e-200, 1e-20, 1e-10}) {
    for (const double dof : {300.0, 3600.0, 1e5, 1e7})
      EXPECT_EQ(chi_squared_upper_tail(value, dof), 1.0) << value << ' ' << dof;
  }
}

TEST(ChiSquared, IsAnExponentialWithTwoDegreesOfFreedom) {
  for (const double value : {0.1, 1.0, 9.0, 60.0}) {
    EXPECT_NEAR(chi_squared_upper_tail(value, 2), std::exp(-0.5 * value), 1e-12 * std::exp(-0.5 * value));
  }
  EXPECT_NEAR(chi_squared_quantile(0.99, 2), -2.0 * std::log(0.01), 1e-12);
}

TEST(ChiSquared, HasTheTabulatedQuantiles) {
  EXPECT_NEAR(chi_squared_quantile(0.95, 1), 3.841, 1e-3);
  EXPECT_NEAR(chi_squared_quantile(0.01, 10), 2.558, 1e-3);
  EXPECT_NEAR(chi_squared_quantile(0.99, 100), 135.807, 1e-3);
}

TEST(ChiSquared, WithoutDegreesOfFreedomIsCertain) {
  EXPECT_EQ(chi_squared_upper_tail(0.0, 0), 1.0);
  EXPECT_EQ(chi_squared_quantile(0.99, 0), 0.0);
}

}  // namespace
}  // namespace mapjoin
