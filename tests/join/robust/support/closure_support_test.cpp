// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/robust/support/closure_support.hpp>
#include <span>
#include <tests/support/dimensions.hpp>
#include <tests/support/two_drives.hpp>

namespace mapjoin {
namespace {

using testing::Crossing;
using testing::two_drives;

/// The log-odds of a closure of which nothing is known.
const double kNothingKnown = std::log(1.0 / 9.0);

template <typename D>
class ClosureSupportTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Two drives with closures between them, and the support of the closures by each other.
  struct Between {
    explicit Between(const std::vector<Crossing>& crossings, double errors = 0.0)
        : log(two_drives<kDim>(140, crossings, errors)) {}
    std::vector<double> odds(const std::vector<PriorOdds>& priors) const { return support.odds(priors, 1.0); }
    std::vector<double> odds() const { return odds(support.priors(1.0)); }

    Log<kDim> log;
    OdometryChain<kDim> chain{log};
    ClosureSupport<kDim> support{chain, log.closures(), 1};
  };

  /// Four closures from each of the poses 20 to 119 of the first drive.
  static std::vector<Crossing> many() {
    std::vector<Crossing> crossings;
    for (std::uint64_t k = 20; k < 120; ++k) {
      for (std::uint64_t more = 0; more < 4; ++more) crossings.push_back({k, k + more});
    }
    return crossings;
  }
  static double scale_of_many(double errors) {
    const Between between(many(), errors);
    return between.support.scale(between.odds());
  }
};
TYPED_TEST_SUITE(ClosureSupportTest, testing::Dimensions);

TYPED_TEST(ClosureSupportTest, LiftsTwoThatMakeALoopWithOdometryAndNotOneThatMakesNone) {
  const typename TestFixture::Between between({{10, 12}, {15, 18}, {20, 20, 3.0}});
  const std::vector<double> odds = between.odds();
  EXPECT_GT(odds[0], 0.0);
  EXPECT_GT(odds[1], 0.0);
  EXPECT_LT(odds[2], kNothingKnown - 5.0);
}

TYPED_TEST(ClosureSupportTest, TakesAClosureEitherWayRound) {
  typename TestFixture::Between between({{10, 12}, {15, 18}});
  PoseFactor<TypeParam::value>& closure = between.log.graph.pose_factors.back();
  std::swap(closure.base, closure.target);
  closure.measured = inverse(closure.measured);
  const ClosureSupport<TypeParam::value> support(between.chain, between.log.closures(), 1);
  EXPECT_GT(support.odds(support.priors(1.0), 1.0)[0], 0.0);
}

TYPED_TEST(ClosureSupportTest, KnowsNothingOfASingleOneBetweenTwoDrives) {
  for (const double wrong_by : {0.0, 30.0}) {
    const typename TestFixture::Between between({{10, 12, wrong_by}});
    EXPECT_EQ(between.odds(), std::vector<double>{kNothingKnown});
  }
}

TYPED_TEST(ClosureSupportTest, DoesNotCompareAcrossMoreThanSixtySteps) {
  const typename TestFixture::Between near({{10, 12}, {40, 42}});
  EXPECT_GT(near.odds()[0], 0.0);
  const typename TestFixture::Between far({{10, 12}, {40, 43}});
  EXPECT_EQ(far.odds()[0], kNothingKnown);
}

TYPED_TEST(ClosureSupportTest, ComparesAcrossMoreStepsWithALongerReach) {
  const typename TestFixture::Between far({{10, 12}, {40, 43}});
  const ClosureSupport<TypeParam::value> support(far.chain, far.log.closures(), 2);
  EXPECT_GT(support.odds(support.priors(1.0), 1.0)[0], 0.0);
  EXPECT_FALSE(support.compares_all());
  EXPECT_TRUE(ClosureSupport<TypeParam::value>(far.chain, far.log.closures(), 16).compares_all());
}

TYPED_TEST(ClosureSupportTest, ReachesAsFarAsTheBestNeedToBeSupported) {
  const auto reach_of = [](const std::vector<Crossing>& crossings) {
    const typename TestFixture::Between between(crossings);
    return supported(between.chain, between.log.closures(), {}).support.longest_loop();
  };
  EXPECT_EQ(reach_of({{10, 12}, {15, 18}, {20, 22}}), 60);
  EXPECT_EQ(reach_of({{10, 10}, {60, 60}, {110, 110}}), 120);
  EXPECT_EQ(reach_of({{10, 10}, {11, 11}, {110, 110}, {111, 111}}), 240);
  EXPECT_EQ(reach_of({{10, 10}}), 60) << "nothing supports it";
}

TEST(OddsOfBest, AreThoseThatOneInAHundredSurpasses) {
  std::vector<double> odds(250, -1.0);
  odds[7] = 5.0;
  EXPECT_EQ(odds_of_best({1.0, 4.0, 2.0}), 4.0);
  EXPECT_EQ(odds_of_best(odds), -1.0);
  odds[8] = odds[9] = 3.0;
  EXPECT_EQ(odds_of_best(odds), 3.0);
}

TYPED_TEST(ClosureSupportTest, CountsThoseThatBearEachOtherOut) {
  const typename TestFixture::Between between({{10, 10}, {12, 12}, {15, 15, 3.0}, {17, 17, 3.0}, {32, 32}, {52, 52}, {54, 54}});
  const auto sizes = [&](const std::vector<bool>& is_asked) { return between.support.set_sizes(is_asked, 1.0); };
  // One set is of the first two, the one 20 steps on and the last two, 20 steps from that; another of the two that are wrong
  // alike.
  EXPECT_EQ(sizes({true, true, true, true, true, true, true}), (std::vector<std::size_t>{5, 5, 2, 2, 5, 5, 5}));
  // Without closure 4 the first two and the last two are two sets, and one that is left alone is a set of its own.
  EXPECT_EQ(sizes({true, true, true, false, false, true, true}), (std::vector<std::size_t>{2, 2, 1, 0, 0, 2, 2}));
}

TYPED_TEST(ClosureSupportTest, TakesThoseOfAStretchForMistakenTogether) {
  std::vector<Crossing> crossings;
  for (std::uint64_t k = 0; k < 10; ++k) crossings.push_back({k, k});
  EXPECT_NEAR((typename TestFixture::Between(crossings).odds()[0]), kNothingKnown + 15.0, 0.01);
  for (std::uint64_t k = 0; k < 5; ++k) crossings[5 + k] = {25 + k, 25 + k};
  EXPECT_NEAR((typename TestFixture::Between(crossings).odds()[0]), kNothingKnown + 30.0, 0.01);
}

TYPED_TEST(ClosureSupportTest, DoesNotAskThoseThatCountAsWrong) {
  const typename TestFixture::Between between({{10, 12}, {15, 18}});
  EXPECT_EQ(between.odds({{}, {.is_wrong = true}})[0], 0.0);
  EXPECT_GT(between.odds({{}, {.is_right = true}})[0], 4.9);
}

TYPED_TEST(ClosureSupportTest, ComparesWithAFewOfAFullCellOnly) {
  std::vector<Crossing> crossings(300, Crossing{3, 3});
  for (std::size_t k = 0; k < 25; ++k) crossings[12 * k].wrong_by = 5.0 + 5.0 * static_cast<double>(k);
  EXPECT_LT((typename TestFixture::Between(crossings).odds().back()), kNothingKnown + 1.0)
      << "it agrees with 274 others, but is compared with 25";
}

TYPED_TEST(ClosureSupportTest, ComparesNoLongerOnceAStopIsRequested) {
  const typename TestFixture::Between between({{10, 12}, {11, 13}});
  EXPECT_GT(between.odds()[0], 0.0);
  std::stop_source source;
  source.request_stop();
  const ClosureSupport<TypeParam::value> support(between.chain, between.log.closures(), 1, source.get_token());
  EXPECT_EQ(support.odds(support.priors(1.0), 1.0)[0], kNothingKnown);
}

TYPED_TEST(ClosureSupportTest, TakesTheWordOfOdometryWithinADrive) {
  constexpr int kDim = TypeParam::value;
  Log<kDim> log = two_drives<kDim>(140, {{10, 12}});
  auto& factors = log.graph.pose_factors;
  PoseFactor<kDim> within = factors.front();
  within.base = 5;
  within.target = 30;
  within.measured.translation[0] = 25.0;
  factors.push_back(within);
  within.measured.translation[1] = 10.0;
  factors.push_back(within);
  const OdometryChain<kDim> chain(log);
  const auto priors = ClosureSupport<kDim>(chain, log.closures(), 1).priors(1.0);
  EXPECT_EQ(priors[0].evidence, kNothingKnown);
  EXPECT_EQ(priors[1].evidence, kNothingKnown + 5.0);
  EXPECT_EQ(priors[2].evidence, kNothingKnown - 20.0);
}

TYPED_TEST(ClosureSupportTest, TakesTheWordOfAMapWithItsCovarianceScaled) {
  constexpr int kDim = TypeParam::value;
  const typename TestFixture::Between between({{10, 12}});
  UncertainPose<kDim> mismatch;
  mismatch.covariance = 1e-4 * PoseMatrix<kDim>::Identity();
  EXPECT_EQ(between.support.prior(mismatch, 1.0).evidence, kNothingKnown + 5.0);
  mismatch.mean.translation[0] = 0.07;  // 7 standard deviations, or 14 and 1.75 of those scaled
  EXPECT_LT(between.support.prior(mismatch, 0.25).evidence, kNothingKnown - 5.0);
  EXPECT_EQ(between.support.prior(mismatch, 16.0).evidence, kNothingKnown + 5.0);
}

TYPED_TEST(ClosureSupportTest, AsksNothingOfATurnThatWasNotMeasured) {
  constexpr int kDim = TypeParam::value;
  const typename TestFixture::Between between({{10, 12}});
  const auto evidence = [&](double variance_of_turn, double turn) {
    UncertainPose<kDim> mismatch;
    mismatch.covariance = 100.0 * PoseMatrix<kDim>::Identity();
    mismatch.covariance.diagonal().template tail<kRotationDof<kDim>>().setConstant(variance_of_turn);
    mismatch.mean.rotation = Rotation<kDim>::exp(turn * RotationVector<kDim>::Unit(0));
    return between.support.prior(mismatch, 1.0).evidence;
  };
  ASSERT_LT(evidence(1.0, 0.0), kNothingKnown + 5.0) << "the most that a map may say for a closure";
  EXPECT_NEAR(evidence(1.0, 1.0), evidence(1.0, 0.0) - 0.5, 1e-9);
  EXPECT_EQ(evidence(1e12, 1.0), evidence(1e9, 0.0));
}

TYPED_TEST(ClosureSupportTest, FindsByHowMuchCovariancesAreTooCautious) {
  EXPECT_NEAR(this->scale_of_many(0.1), 0.01, 0.005);
  EXPECT_GT(this->scale_of_many(1.0), 0.5);
  EXPECT_EQ(this->scale_of_many(3.0), 1.0) << "never too sure";
}

TYPED_TEST(ClosureSupportTest, FindsTheScaleByTheBestSupportedTwentieth) {
  typename TestFixture::Between between(this->many(), 0.1);
  const std::size_t count = between.log.closures().size();
  const std::size_t best = count / 15;
  std::vector<double> odds(count, 20.0);
  std::fill_n(odds.begin(), best, 100.0);
  const auto closures = std::span(between.log.graph.pose_factors).last(count);
  for (std::size_t k = best; k < count; ++k) {
    closures[k].measured.translation[0] += 0.02 * (static_cast<double>(k % 5) - 2.0);  // up to four standard deviations
  }
  const ClosureSupport<TypeParam::value> support(between.chain, between.log.closures(), 1);
  EXPECT_LT(support.scale(odds), 0.02);
  // Among all closures one loop in five is of two that are off alike, and agrees as closely.
  const double of_all = support.scale(std::vector<double>(count, 20.0));
  EXPECT_GT(of_all, 0.02);
  EXPECT_LT(of_all, 0.08);
}

TYPED_TEST(ClosureSupportTest, FindsNoScaleByCopies) {
  typename TestFixture::Between between({{0, 0}, {15, 15}, {30, 30}, {45, 45}, {60, 60}, {75, 75}, {90, 90}, {105, 105}}, 1.0);
  auto& factors = between.log.graph.pose_factors;
  const std::size_t count = between.log.closures().size();
  for (std::size_t k = 0; k < 2 * count; ++k) factors.push_back(factors[factors.size() - count]);
  const ClosureSupport<TypeParam::value> support(between.chain, between.log.closures(), 1);
  EXPECT_GT(support.scale(std::vector<double>(3 * count, 20.0)), 0.2)
      << "a sixth of the loops are of copies, which fit exactly";
}

TYPED_TEST(ClosureSupportTest, BelievesNoScaleOfAFewLoops) {
  auto few = this->many();
  few.resize(12);
  const typename TestFixture::Between between(few, 0.1);
  EXPECT_EQ(between.support.scale(std::vector<double>(few.size(), 20.0)), 1.0) << "66 loops";
  few = this->many();
  few.resize(16);
  const typename TestFixture::Between more(few, 0.1);
  EXPECT_LT(more.support.scale(std::vector<double>(few.size(), 20.0)), 0.1) << "120 loops";
}

}  // namespace
}  // namespace mapjoin
