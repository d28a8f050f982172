// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/solve/trust_region.hpp>

namespace mapjoin {
namespace {

/// A step of length 1 by which the model lowers chi2 by `decrease`.
ModelStep promising(double decrease) {
  return {Eigen::VectorXd::Ones(1), decrease, 1.0};
}

/// A trust region that has judged a step that promised to lower chi2 by 1 and lowered it by `gain`.
TrustRegion after(double gain, Method method = Method::kDogleg, double chi2 = 1e3) {
  TrustRegion region(method);
  region.set_newton_step(promising(1.0));
  region.step();
  region.judge(chi2, chi2 - gain);
  return region;
}

TEST(TrustRegion, AcceptsNoStepThatGainsNothing) {
  for (const auto method : {Method::kDogleg, Method::kLevenbergMarquardt}) {
    EXPECT_FALSE(after(-1.0, method).accepted());
    EXPECT_FALSE(after(0.5e-4, method).accepted());
    EXPECT_TRUE(after(2e-4, method).accepted());
  }
}

TEST(TrustRegion, AStepFallsShortBelowFourTenthsOfItsPromise) {
  EXPECT_TRUE(after(0.39).fell_short());
  EXPECT_FALSE(after(0.41).fell_short());
}

TEST(TrustRegion, CreepsWhereStepsOfLittleUseGainFarLessOrMoreThanTheyPromise) {
  for (const auto& [gain, creeps] : {std::pair{0.39, true}, {0.41, false}, {1.49, false}, {1.51, true}}) {
    EXPECT_EQ(after(gain).creeps(), creeps) << gain;
    EXPECT_FALSE(after(gain, Method::kDogleg, 10.0).creeps()) << gain;
  }
}

TEST(TrustRegion, AFactorMayServeAgainWhereItsStepLoweredChi2ByAHundredthAtMost) {
  EXPECT_FALSE(after(1.0).may_repeat(99.0));
  EXPECT_TRUE(after(1.0).may_repeat(101.0));
  EXPECT_FALSE(after(-1.0).may_repeat(101.0));
  EXPECT_FALSE(after(1.0, Method::kLevenbergMarquardt).may_repeat(101.0));
}

TEST(TrustRegion, AFactorServesAgainWhereItsStepPromisesATwentiethOfTheOneBeforeAtMost) {
  for (const double promise : {0.049, 0.051}) {
    TrustRegion region = after(1.0);
    region.propose_repeated(promising(promise));
    EXPECT_EQ(region.needs_factorisation(), promise > 0.05);
  }
}

TEST(TrustRegion, AStepThatIsRefusedNeedsAnotherFactorOnlyWhereItsOwnWasOld) {
  EXPECT_FALSE(after(-1.0).needs_factorisation());
  TrustRegion region = after(1.0);
  region.propose_repeated(promising(0.01));
  region.step();
  region.judge(1.0, 2.0);
  EXPECT_TRUE(region.needs_factorisation());
}

TEST(TrustRegion, TheFactorOfATruncatedStepDoesNotServeAgain) {
  TrustRegion region = after(-1.0);
  ASSERT_TRUE(region.is_truncated());
  region.set_cauchy_point(promising(0.5), Unmeasured{});
  region.step();
  region.judge(1.0, 1.0 - region.predicted_decrease());
  EXPECT_TRUE(region.accepted());
  EXPECT_FALSE(region.may_repeat(1e9));
}

TEST(TrustRegion, AStepThatIsCutShortOnTheWayDownPromisesWhatIsLeftOfIt) {
  // At a share s of the way to the Cauchy point the model has 2 s - s² of the decrease there.
  TrustRegion region = after(-1.0);  // the step had length 1: a quarter is tried next
  region.set_cauchy_point(promising(0.8), Unmeasured{});
  EXPECT_DOUBLE_EQ(region.step()[0], 0.25);
  EXPECT_DOUBLE_EQ(region.predicted_decrease(), 0.8 * (2.0 * 0.25 - 0.25 * 0.25));
}

TEST(TrustRegion, DampingGrowsEverFasterUntilAStepIsTaken) {
  TrustRegion region(Method::kLevenbergMarquardt);
  for (const double growth : {2.0, 4.0, 8.0}) {
    const double before = region.damping();
    region.set_newton_step(promising(1.0));
    region.step();
    region.judge(1.0, 2.0);
    EXPECT_DOUBLE_EQ(region.damping(), growth * before);
  }
}

}  // namespace
}  // namespace mapjoin
