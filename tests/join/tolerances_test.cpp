// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <mapjoin/join/tolerances.hpp>

namespace mapjoin {
namespace {

TEST(Tolerances, OneOptimumIsToldFromItsNeighbours) {
  for (const double chi2 : {1e-3, 1.0, 1e6}) {
    const double unit = std::max(1.0, chi2);
    EXPECT_TRUE(is_same_chi2(chi2, chi2 + 1e-8 * unit));
    EXPECT_FALSE(is_same_chi2(chi2, chi2 + 1e-4 * unit));
    EXPECT_TRUE(is_less_chi2(chi2, chi2 + 1e-4 * unit));
    EXPECT_FALSE(is_less_chi2(chi2 + 1e-4 * unit, chi2));
    EXPECT_FALSE(is_less_chi2(chi2, chi2 + 1e-8 * unit));
  }
}

TEST(Tolerances, AChi2ThatIsNotFiniteIsNeverBetter) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_less_chi2(nan, 1.0));
  EXPECT_TRUE(is_less_chi2(1.0, nan));
}

}  // namespace
}  // namespace mapjoin
