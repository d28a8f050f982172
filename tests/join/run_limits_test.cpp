// SPDX-License-Identifier: BSD-3-Clause
// A run at its limits: bad logs, stops on request, a limit on iterations, and any number of threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <mapjoin/join/run.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::small_world;

template <typename D>
class RunLimitsTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static RunOptions short_maps() {
    RunOptions options;
    options.split = {SplitRule::kPoses, 6.0};
    return options;
  }
};
TYPED_TEST_SUITE(RunLimitsTest, testing::Dimensions);

TYPED_TEST(RunLimitsTest, ALogThatFallsApartIsBadInput) {
  const auto world = small_world<TestFixture::kDim>({.features = 0, .sessions = 2});
  for (const auto& result : {run(world.log, this->short_maps()), solve(world.log, this->short_maps())}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(result.error().message,
                AllOf(HasSubstr("small world: "), HasSubstr("2 parts"), HasSubstr("pose 0 of session 1")));
  }
}

TYPED_TEST(RunLimitsTest, NumbersTooLargeForAFiniteChi2AreBadInput) {
  auto world = small_world<TestFixture::kDim>();
  world.log.graph.pose_factors.back().measured.translation[0] = 1e200;
  for (const auto& result : {run(world.log, this->short_maps()), solve(world.log, this->short_maps())}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(result.error().message,
                HasSubstr("small world: its numbers are too large: the map is not finite, or its chi2"));
  }
}

/// Ten thousand kilometres from the origin, where positions are rounded to nanometres, by the size of the noise.
TYPED_TEST(RunLimitsTest, ALogFarFromTheOriginConverges) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 60, .features = 20, .closures = 12, .noise = 1e-5});
  for (auto& edge : world.log.graph.pose_factors) edge.information = 1e10 * PoseMatrix<kDim>::Identity();
  for (auto& seen : world.log.graph.feature_factors) seen.information = 1e10 * PointMatrix<kDim>::Identity();
  const double at_origin = run(world.log, {}).value().chi2;
  Pose<kDim> far;
  far.translation.setConstant(1e7);
  world.log.graph.fixed = {{0, far}};
  const auto result = run(world.log, {}).value();
  EXPECT_TRUE(result.converged());
  EXPECT_NEAR(result.chi2, at_origin, 1e-3 * at_origin);
}

TYPED_TEST(RunLimitsTest, ASplitThatIsNotOfTheLogIsBadInput) {
  const auto world = small_world<TestFixture::kDim>();
  Split parts = split(world.log, this->short_maps().split);
  const auto maps = build_local_maps(world.log, parts, {}).value().maps;
  ASSERT_TRUE(run_from_maps(world.log, parts, maps, RunOptions{}));
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}}) {
    parts.kept.resize(size);
    const auto result = run_from_maps(world.log, parts, maps, RunOptions{});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(result.error().message, HasSubstr("which of them stay"));
  }
}

TYPED_TEST(RunLimitsTest, AFeatureThatIsNotDeterminedIsNamed) {
  auto world = small_world<TestFixture::kDim>();
  world.log.features[3].key = 4711;
  for (auto& o : world.log.graph.feature_factors) {
    if (o.target != 3) continue;
    o.information.setZero();
    o.information(0, 0) = 1.0;
    o.measured[0] = 1.0;
    o.base = 0;  // all from one pose and along one axis: nothing fixes the other coordinates
  }
  const auto in_order = [](const auto& a, const auto& b) { return a.base < b.base; };
  std::stable_sort(world.log.graph.feature_factors.begin(), world.log.graph.feature_factors.end(), in_order);
  for (const auto& result : {run(world.log, this->short_maps()), solve(world.log, this->short_maps())}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(result.error().message, HasSubstr("feature 4711 cannot be determined"));
  }
}

TYPED_TEST(RunLimitsTest, SessionsTiedByTooFewFeaturesAreNotDetermined) {
  auto world = small_world<TestFixture::kDim>({.features = 1, .closures = 0, .sessions = 2, .range = 30.0});
  const auto result = run(world.log, this->short_maps());
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message,
              HasSubstr("cannot be determined: the observations leave them free to turn as a whole about feature"));
}

TYPED_TEST(RunLimitsTest, StopsInEveryStage) {
  const auto world = small_world<TestFixture::kDim>();
  for (const auto stage : {Stage::kBuild, Stage::kJoin, Stage::kRecover, Stage::kPolish, Stage::kCovariances}) {
    std::stop_source stop;
    RunOptions options = this->short_maps();
    options.progress = [&](Stage at, std::size_t, std::size_t) {
      if (at == stage) stop.request_stop();
    };
    const auto result = run(world.log, options, stop.get_token());
    ASSERT_FALSE(result) << static_cast<int>(stage);
    EXPECT_EQ(result.error().kind, ErrorKind::kInterrupted);
  }
}

TYPED_TEST(RunLimitsTest, ALimitOnIterationsIsReportedAndTheMapStillGiven) {
  const auto world = small_world<TestFixture::kDim>({.noise = 0.1});
  RunOptions options = this->short_maps();
  options.solver.max_iterations = 1;
  const auto result = run(world.log, options);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->converged());
  EXPECT_EQ(result->map.poses.size(), world.log.poses.size());
}

TYPED_TEST(RunLimitsTest, AnyNumberOfThreadsGivesTheSameBits) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>({.poses = 300, .features = 200, .closures = 20, .sessions = 2});
  for (const auto method : {Method::kDogleg, Method::kLevenbergMarquardt}) {
    RunOptions options = this->short_maps();
    options.solver.method = method;
    std::vector<RunResult<kDim>> results;
    for (const std::size_t threads : {1u, 2u, 5u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      auto result = run(world.log, options);
      ASSERT_TRUE(result) << result.error().message;
      results.push_back(*std::move(result));
    }
    for (const auto& result : results) {
      EXPECT_EQ(result.chi2, results[0].chi2);
      EXPECT_EQ(*result.recovered_chi2, *results[0].recovered_chi2);
      for (const PoseIndex p : indices(result.map.poses)) {
        EXPECT_EQ(result.map.poses[p].translation, results[0].map.poses[p].translation);
        EXPECT_EQ(result.map.poses[p].rotation.matrix(), results[0].map.poses[p].rotation.matrix());
      }
      EXPECT_EQ(result.map.features, results[0].map.features);
    }
  }
}

}  // namespace
}  // namespace mapjoin
