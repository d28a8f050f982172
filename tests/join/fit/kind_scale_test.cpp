// SPDX-License-Identifier: BSD-3-Clause
// The scales of the residuals of kinds of measurements, which these are judged against.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/run.hpp>
#include <span>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/fit_of.hpp>

namespace mapjoin {
namespace {

/// The scale of a kind that must have been tested.
KindScale kind_scale(PartKind kind, const GoodnessOfFit& fit) {
  const auto found = std::ranges::find(fit.kinds, kind, &KindScale::kind);
  EXPECT_NE(found, fit.kinds.end());
  return fit.kinds.at(static_cast<std::size_t>(found - fit.kinds.begin()));
}

template <typename D>
class KindScaleTest : public ::testing::Test {};
TYPED_TEST_SUITE(KindScaleTest, testing::Dimensions, );

TYPED_TEST(KindScaleTest, TellsCovariancesThatAreTooSmallFromOutliers) {
  testing::ClosingWorld<TypeParam::value> world(300, 5);
  for (auto& observation : world.log.graph.feature_factors) observation.information *= 9.0;
  const GoodnessOfFit fit = testing::fit_of(world.log);
  EXPECT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_TRUE(fit.misfits.empty());
  for (const KindScale& kind : fit.kinds) EXPECT_EQ(kind.is_too_certain, kind.kind == PartKind::kObservation);
  const KindScale observations = kind_scale(PartKind::kObservation, fit);
  EXPECT_NEAR(observations.scale, 9.0, 1.5);
}

TYPED_TEST(KindScaleTest, CallsNoKindTooCertainWhereChi2IsProbable) {
  int larger = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const GoodnessOfFit fit = testing::fit_of(testing::ClosingWorld<TypeParam::value>(30, seed).log);
    if (fit.verdict != Verdict::kFits) continue;
    for (const KindScale& kind : fit.kinds) {
      larger += kind.scale > 1.0;
      EXPECT_FALSE(kind.is_too_certain) << seed;
    }
  }
  EXPECT_GT(larger, 0);
}

/// Observations with too much information are no outliers if enough others confirm the scale of their errors.
TYPED_TEST(KindScaleTest, TrustsTheScaleOfAKindThatEnoughOthersConfirm) {
  testing::ClosingWorld<TypeParam::value> world(25, 5);
  for (auto& observation : world.log.graph.feature_factors) observation.information *= 25.0;
  const GoodnessOfFit fit = testing::fit_of(world.log);
  const KindScale observations = kind_scale(PartKind::kObservation, fit);
  ASSERT_GT(observations.confirmed, 20.0);
  EXPECT_TRUE(fit.misfits.empty());
}

/// A third of the closures are wrong, and bend the rest, so that all closures look worse than they are.
TEST(KindScale, FindsScalesAnewWithoutEachMisfit) {
  std::size_t named = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    testing::ClosingWorld<2> world(300, seed, 40);
    const std::size_t right = world.log.graph.pose_factors.size();
    for (int k = 0; k < 20; ++k) world.add_closure();
    std::vector<PoseFactor<2>>& factors = world.log.graph.pose_factors;
    for (std::size_t k = right; k < factors.size(); ++k) {
      factors[k].measured = retract<2>(factors[k].measured, PoseVector<2>(0.3 * testing::normal_step<2>(world.random)));
    }
    const GoodnessOfFit fit = testing::fit_of(world.log);
    named += fit.misfits.size();
    for (const Misfit& misfit : fit.misfits) EXPECT_EQ(misfit.kind, PartKind::kClosure) << seed;
    const KindScale closures = kind_scale(PartKind::kClosure, fit);
    EXPECT_EQ(closures.parts, 60 - fit.misfits.size());
    EXPECT_LT(closures.scale, 2.0) << seed;
  }
  EXPECT_GT(named, 50U);
}

/// Eight closures that all else confirms well, one of them wrong, among measurements whose errors are three times as large as
/// stated: its own error is judged as given.
TEST(KindScale, FindsOneOfFewMeasurementsThatAreWellConfirmedAmongMoreThatAreTooCertain) {
  ManhattanOptions options;
  options.poses = 500;
  options.noise_multiplier = 3.0;
  const auto simulation = simulate_manhattan<2>(options);
  for (const double error : {0.0, 2.0}) {
    Log<2> log = simulation.log;
    RandomStream random(1, 7);
    for (std::size_t k = 0; k < 8; ++k) {
      const PoseIndex base(20 * k), target(400 + 10 * k);
      const auto& truth = simulation.truth.poses;
      const PoseVector<2> e = 0.2 * testing::normal_step<2>(random) + (k == 3 ? error : 0.0) * PoseVector<2>::UnitX();
      log.graph.pose_factors.push_back(
          {base, target, retract<2>(between(truth[base], truth[target]), e), 25.0 * PoseMatrix<2>::Identity()});
    }
    const GoodnessOfFit fit = testing::fit_of(log);
    EXPECT_EQ(fit.misfits.size(), error > 0.0 ? 1U : 0U);
    for (const Misfit& misfit : fit.misfits) EXPECT_EQ(misfit.from, PoseIndex(60));
  }
}

/// Closures whose errors are five times as large as stated, all of them, bend odometry, which hardly anything else confirms.
TYPED_TEST(KindScaleTest, JudgesAKindThatIsHardlyConfirmedByTheScaleOfTheOthers) {
  constexpr int kDim = TypeParam::value;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    testing::ClosingWorld<kDim> world(300, seed, 40);
    world.log.graph.feature_factors.clear();
    world.log.features = {};
    for (auto& closure : std::span(world.log.graph.pose_factors).subspan(world.log.odometry().size())) {
      closure.information /= 400.0;
      closure.measured = retract<kDim>(closure.measured, PoseVector<kDim>(5.0 * testing::normal_step<kDim>(world.random)));
    }
    const GoodnessOfFit fit = testing::fit_of(world.log);
    const KindScale odometry = kind_scale(PartKind::kOdometry, fit);
    EXPECT_LT(odometry.confirmed, 20.0);
    EXPECT_EQ(fit.verdict, Verdict::kMisfit);
    for (const Misfit& misfit : fit.misfits) EXPECT_NE(misfit.kind, PartKind::kOdometry) << seed;
  }
}

TYPED_TEST(KindScaleTest, CallsNothingAMisfitThatCautiousCovariancesAllow) {
  testing::ClosingWorld<TypeParam::value> world(100, 6);
  for (auto& observation : world.log.graph.feature_factors) observation.information /= 25.0;
  auto& off = world.log.graph.feature_factors[world.log.observations().size() / 2];
  off.measured[0] += 3.0 / std::sqrt(off.information(0, 0));  // far more than others, no more than is stated
  const GoodnessOfFit fit = testing::fit_of(world.log);
  EXPECT_EQ(fit.verdict, Verdict::kFits);
  const KindScale observations = kind_scale(PartKind::kObservation, fit);
  EXPECT_NEAR(observations.scale, 1.0 / 25.0, 0.01);
}

}  // namespace
}  // namespace mapjoin
