// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/closing_world.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/fit_of.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class GoodnessOfFitTest : public ::testing::Test {};
TYPED_TEST_SUITE(GoodnessOfFitTest, testing::Dimensions, );

TYPED_TEST(GoodnessOfFitTest, OfAThousandConsistentWorldsHardlyMoreThanTenAreCalledMisfits) {
  int misfits = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    const testing::ClosingWorld<TypeParam::value> world(TypeParam::value == 2 ? 60 : 25, seed);
    misfits += testing::fit_of(world.log).verdict == Verdict::kMisfit;
  }
  this->RecordProperty("misfits", misfits);
  EXPECT_LE(misfits, 18);  // ten, and two and a half standard deviations
  EXPECT_GE(misfits, 3);   // the level is spent
}

TYPED_TEST(GoodnessOfFitTest, ASharpClosureOfALongLoopIsBlamedBeforeOdometry) {
  constexpr int kDim = TypeParam::value;
  auto log = testing::small_world<kDim>({.poses = 60, .features = 0, .closures = 1, .noise = 1e-4}).log;
  for (PoseFactor<kDim>& edge : log.graph.pose_factors) edge.information *= 1e6;
  PoseFactor<kDim>& closure = log.graph.pose_factors.back();
  closure.information *= 1e4;
  closure.measured.translation[0] += 1.0;
  const GoodnessOfFit fit = testing::fit_of(log);
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kClosure);
  EXPECT_GE(fit.misfits.at(0).rows, kPoseDof<kDim> - 1);
}

TYPED_TEST(GoodnessOfFitTest, NoClosureThatIsWrongByTenIsMissed) {
  constexpr int kDim = TypeParam::value;
  int named_first = 0;
  constexpr int kWorlds = kDim == 2 ? 1000 : 300;
  for (std::uint64_t seed = 1; seed <= kWorlds; ++seed) {
    testing::ClosingWorld<kDim> world(kDim == 2 ? 60 : 25, seed);
    PoseIndex base = 0, target = 0;
    while (std::abs(target - base) < 2) base = world.any_pose(), target = world.any_pose();
    RunOptions options = without_verdict();
    options.covariances = true;
    const auto right = run(world.log, options).value();
    PoseMatrix<kDim> S = right.covariances->relative_pose(base, target).value();
    S.diagonal().array() += 0.05 * 0.05;
    const PoseVector<kDim> direction = testing::normal_step<kDim>(world.random).normalized();
    const PoseVector<kDim> shift = 10.0 * PoseVector<kDim>(S.llt().matrixL() * direction);
    world.add(base, target, retract<kDim>(between(right.map.poses[base], right.map.poses[target]), shift));
    const GoodnessOfFit fit = testing::fit_of(world.log);
    ASSERT_EQ(fit.verdict, Verdict::kMisfit) << "seed " << seed;
    const Misfit& worst = fit.misfits.at(0);
    named_first += worst.kind == PartKind::kClosure && worst.from == base && worst.to == PoseOrFeature(target);
  }
  this->RecordProperty("named_first", named_first);
  EXPECT_GE(named_first, 0.97 * kWorlds);
}

/// The log with one closure, by its place among the closures, off by `shift` in each coordinate of its position.
template <int Dim>
Log<Dim> with_wrong_closure(Log<Dim> log, std::size_t closure, double shift) {
  PoseFactor<Dim>& wrong = log.graph.pose_factors[log.odometry().size() + closure];
  wrong.measured.translation += Point<Dim>::Constant(shift);
  return log;
}

TYPED_TEST(GoodnessOfFitTest, TellsChi2AndItsDegreesOfFreedomWithoutTheMisfits) {
  constexpr int kDim = TypeParam::value;
  const testing::ClosingWorld<kDim> world(60, 3);
  const GoodnessOfFit fit = testing::fit_of(with_wrong_closure(world.log, 2, 1.0));
  ASSERT_EQ(fit.misfits.size(), 1U);
  Log<kDim> without = world.log;
  without.graph.pose_factors.erase(without.graph.pose_factors.begin() + std::ssize(world.log.odometry()) + 2);
  const auto right = run(without, {}).value();
  EXPECT_EQ(fit.dof, right.dof);
  EXPECT_NEAR(fit.chi2, right.chi2, 1e-2 * right.chi2);
  EXPECT_NEAR(fit.misfits[0].probability,
              static_cast<double>(fit.parts) * chi_squared_upper_tail(fit.misfits[0].chi2, kPoseDof<kDim>),
              1e-9 * fit.misfits[0].probability);
}

TYPED_TEST(GoodnessOfFitTest, TestsTheOthersAnewWithoutAMisfit) {
  const testing::ClosingWorld<TypeParam::value> world(60, 3);
  const GoodnessOfFit one = testing::fit_of(with_wrong_closure(world.log, 2, 0.6));
  const GoodnessOfFit both = testing::fit_of(with_wrong_closure(with_wrong_closure(world.log, 2, 0.6), 5, 0.6));
  EXPECT_TRUE(both.is_complete) << "these hardly turn the map";
  ASSERT_EQ(both.misfits.size(), 2U);
  for (const Misfit& misfit : both.misfits) EXPECT_EQ(misfit.kind, PartKind::kClosure);
  EXPECT_NEAR(both.chi2, one.chi2, 0.1 * one.chi2);
}

TYPED_TEST(GoodnessOfFitTest, OfManyPartsOneMisfitIsEnoughWhateverChi2AsAWholeSays) {
  const testing::ClosingWorld<TypeParam::value> world(TypeParam::value == 2 ? 600 : 200, 5);
  RunOptions options;
  options.most_misfits = 0;
  const GoodnessOfFit fit = run(with_wrong_closure(world.log, 4, TypeParam::value == 2 ? 0.5 : 0.3), options).value().fit;
  ASSERT_GT(fit.probability, 0.01);
  EXPECT_EQ(fit.verdict, Verdict::kMisfit);
}

TYPED_TEST(GoodnessOfFitTest, NamesPriorsThatDoNotFit) {
  constexpr int kDim = TypeParam::value;
  const testing::ClosingWorld<kDim> world(60, 3);
  const auto map = run(world.log, {}).value().map;
  for (const bool is_of_pose : {true, false}) {
    Log<kDim> log = world.log;
    for (const std::size_t k : {2U, 7U, 12U}) {
      log.graph.feature_factors.push_back(
          {kWorld, FeatureIndex(k), map.features[FeatureIndex(k)], 100.0 * PointMatrix<kDim>::Identity()});
      log.graph.pose_factors.push_back(
          {kWorld, PoseIndex(4 * k), map.poses[PoseIndex(4 * k)], 100.0 * PoseMatrix<kDim>::Identity()});
    }
    Point<kDim>& wrong =
        is_of_pose ? log.graph.pose_factors.back().measured.translation : log.graph.feature_factors.back().measured;
    wrong[0] += 3.0;
    const GoodnessOfFit fit = testing::fit_of(log);
    ASSERT_FALSE(fit.misfits.empty());
    EXPECT_EQ(fit.misfits[0].kind, PartKind::kPrior);
    EXPECT_EQ(fit.misfits[0].from, kWorld);
    EXPECT_EQ(fit.misfits[0].to, is_of_pose ? PoseOrFeature(PoseIndex(48)) : PoseOrFeature(FeatureIndex(12)));
  }
}

TYPED_TEST(GoodnessOfFitTest, NamesAFeatureThatIsNotTheOneItIsSaidToBe) {
  testing::ClosingWorld<TypeParam::value> world(80, 3);
  auto& observation = world.log.graph.feature_factors[world.log.observations().size() / 2];
  const FeatureIndex right = observation.target;
  observation.target = right == 0 ? FeatureIndex(world.log.features.size() - 1) : FeatureIndex(0);
  const GoodnessOfFit fit = testing::fit_of(world.log);
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kObservation);
  EXPECT_EQ(fit.misfits.at(0).from, observation.base);
  EXPECT_EQ(fit.misfits.at(0).to, PoseOrFeature(observation.target));
}

/// A square driven round once, which ends where it begins, with closures from its last poses to its first.
Log<2> square(double error_of_step_7, int closures) {
  LogBuilder<2> builder("square");
  const PoseMatrix<2> W = 1e4 * PoseMatrix<2>::Identity();
  for (std::uint64_t k = 1; k <= 40; ++k) {
    const double error = k == 7 ? error_of_step_7 : 0.0;
    builder.add_pose_edge({0, k - 1}, {0, k}, {{1.0 + error, 0.0}, Rotation<2>(k % 10 == 0 ? std::numbers::pi / 2 : 0.0)}, W);
  }
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(closures); ++k) {
    const Rotation<2> turn(k == 0 ? 0.0 : std::numbers::pi / 2);
    builder.add_pose_edge({0, 40 - k}, {0, 0}, {{static_cast<double>(k), 0.0}, turn}, W);
  }
  return std::move(builder).finish().value();
}

TEST(GoodnessOfFit, BlamesTheClosureWhereOneClosesALoopAndOdometryWhereTwoAgree) {
  const GoodnessOfFit one = testing::fit_of(square(5.0, 1));
  ASSERT_EQ(one.verdict, Verdict::kMisfit);
  EXPECT_EQ(one.misfits.at(0).kind, PartKind::kClosure);
  const GoodnessOfFit two = testing::fit_of(square(5.0, 8));
  ASSERT_EQ(two.verdict, Verdict::kMisfit);
  EXPECT_EQ(two.misfits.at(0).kind, PartKind::kOdometry);
}

TEST(GoodnessOfFit, WaitsForAMapWithoutAMisfitThatBentItFar) {
  EXPECT_FALSE(testing::fit_of(square(15.0, 1)).is_complete);
}

/// A long round, of each step of which the others tell next to nothing, with a closure that is off by five metres.
TEST(GoodnessOfFit, TestsTheClosureOfALongRound) {
  LogBuilder<2> builder("round");
  constexpr std::uint64_t kSteps = 3000;
  const PoseMatrix<2> W = Eigen::Vector3d(1e4, 1e4, 1e8).asDiagonal();
  const double turn = 2.0 * std::numbers::pi / static_cast<double>(kSteps);
  for (std::uint64_t k = 1; k <= kSteps; ++k) {
    builder.add_pose_edge({0, k - 1}, {0, k}, {{0.01, 0.0}, Rotation<2>(turn)}, W);
  }
  builder.add_pose_edge({0, kSteps}, {0, 0}, {{5.0, 0.0}, Rotation<2>(0.0)}, W);
  const GoodnessOfFit fit = testing::fit_of(std::move(builder).finish().value());
  ASSERT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_EQ(fit.misfits.at(0).kind, PartKind::kClosure);
}

TEST(GoodnessOfFit, IsUntestedWhereNothingIsMeasuredTwice) {
  const GoodnessOfFit fit = testing::fit_of(square(0.0, 0));
  EXPECT_EQ(fit.verdict, Verdict::kUntested);
  EXPECT_EQ(fit.parts, 0U);
  EXPECT_EQ(testing::fit_of(square(0.0, 1)).verdict, Verdict::kFits);
}

TEST(GoodnessOfFit, IsUntestedOfALongWayThatNothingCloses) {
  LogBuilder<2> builder("line");
  for (std::uint64_t k = 1; k <= 10000; ++k) {
    builder.add_pose_edge({0, k - 1}, {0, k}, {{1.0, 0.0}, Rotation<2>(0.01)}, PoseMatrix<2>::Identity());
  }
  EXPECT_EQ(testing::fit_of(std::move(builder).finish().value()).verdict, Verdict::kUntested);
}

TEST(GoodnessOfFit, NamesNoMoreMisfitsThanAskedForAndIsOneAllTheSame) {
  RunOptions options;
  options.most_misfits = 0;
  const GoodnessOfFit fit = run(square(5.0, 8), options).value().fit;
  EXPECT_EQ(fit.verdict, Verdict::kMisfit);
  EXPECT_TRUE(fit.misfits.empty());
  EXPECT_FALSE(fit.is_complete);
}

TEST(GoodnessOfFit, IsNotAskedOfAMapThatIsNoOptimum) {
  const testing::ClosingWorld<2> world(100, 7);
  RunOptions options;
  options.solver.max_iterations = 1;
  options.solver.method = Method::kGaussNewton;
  EXPECT_EQ(run(world.log, options).value().fit.verdict, Verdict::kUnconverged);
  EXPECT_EQ(run(world.log, without_verdict()).value().fit.verdict, Verdict::kUntested);
}

TEST(GoodnessOfFit, IsUntestedWithAReasonWhereMemoryDoesNotDo) {
  const testing::ClosingWorld<2> world(100, 8);
  RunOptions options;
  options.most_memory = 1000;
  const auto result = run(world.log, options).value();
  EXPECT_EQ(result.fit.verdict, Verdict::kUntested);
  ASSERT_TRUE(result.no_verdict);
  EXPECT_EQ(result.no_verdict->kind, ErrorKind::kTooLarge);
}

}  // namespace
}  // namespace mapjoin
