// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <numbers>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/every.hpp>
#include <tests/support/places.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::full_slam;
using testing::largest_difference;
using testing::small_world;
using testing::SmallWorld;
using testing::WorldOptions;

template <typename D>
class RunTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static RunOptions with(double poses_per_map, Schedule schedule = Schedule::kTree, Method method = Method::kDogleg) {
    RunOptions options;
    options.split = {SplitRule::kPoses, poses_per_map};
    options.schedule = schedule;
    options.solver.method = method;
    return options;
  }
  static Values<kDim> state_of(const RunResult<kDim>& result) { return {result.map.poses, result.map.features}; }

  /// Expects the dense optimum of the whole log: every pose and feature, chi2, and no gradient left.
  static void expect_full_slam(const SmallWorld<kDim>& world, const Expected<RunResult<kDim>>& result) {
    ASSERT_TRUE(result) << result.error().message;
    const auto slam = full_slam(world.log);
    const Values<kDim> optimum = slam.optimum(world.truth);
    const Values<kDim> state = state_of(*result);
    EXPECT_TRUE(result->converged());
    EXPECT_LT(largest_difference(state, optimum), 1e-6);
    const double chi2 = slam.linearise(optimum).chi2;
    EXPECT_NEAR(result->chi2, chi2, 1e-9 * chi2);
    EXPECT_NEAR(result->chi2, log_chi2(world.log, state).total(), 1e-12 * chi2);  // turns are taken off the state
    EXPECT_LT(slam.linearise(state).g.norm(), 1e-6 * slam.linearise(world.truth).g.norm());
  }
};
TYPED_TEST_SUITE(RunTest, testing::Dimensions);

TEST(Run, RefinesToTheSameMapWithinMicrometresHoweverTheLogIsSplit) {
  const auto log = std::get<Log<2>>(open_log(testing::kBundledData / "manhattan2d.g2o").value());
  std::vector<Values<2>> maps;
  for (const double poses : {3.0, 7.0, 20.0, 50.0}) {
    RunOptions options;
    options.split = {SplitRule::kPoses, poses};
    const auto map = run(log, options).value().map;
    maps.push_back(Values<2>{map.poses, map.features});
    EXPECT_LT(largest_difference(maps.front(), maps.back()), 4e-6) << poses;  // a third of what a join alone leaves
  }
}

TEST(Run, CountsTheRowsOfMapsThatHangSoftlyOnTheirBase) {
  auto log = std::get<Log<2>>(open_log(testing::kBundledData / "manhattan2d.g2o").value());
  RunOptions options;
  options.split = {SplitRule::kPoses, 20.0};
  const auto dof = run(log, options).value().join.dof;
  for (auto& edge : log.graph.pose_factors) edge.information *= 1e-4;
  for (auto& observation : log.graph.feature_factors) observation.information *= 1e6;
  EXPECT_EQ(run(log, options).value().join.dof, dof);
}

TYPED_TEST(RunTest, EndsAtTheFullSlamOptimumForMapsOfAnyLength) {
  const auto world = small_world<TestFixture::kDim>({.reversed_odometry = true});
  for (const double poses : {1.0, 2.0, 5.0, 10.0, 39.0, 1000.0}) {
    SCOPED_TRACE(poses);
    const auto result = run(world.log, this->with(poses));
    this->expect_full_slam(world, result);
    EXPECT_GE(*result->recovered_chi2, result->chi2 * (1.0 - 1e-9));
    EXPECT_LE(*result->recovered_chi2, result->chi2 * 1.01);
  }
}

TYPED_TEST(RunTest, EndsAtTheFullSlamOptimumByEveryScheduleAndMethod) {
  const auto world = small_world<TestFixture::kDim>({.features = 40, .closures = 5, .range = 2.5, .noise = 0.03, .seed = 3});
  for (const auto schedule : testing::every<Schedule>()) {
    for (const auto method : testing::every<Method>()) {
      SCOPED_TRACE(to_string(schedule) + " " + to_string(method));
      this->expect_full_slam(world, run(world.log, this->with(6.0, schedule, method)));
    }
  }
}

TYPED_TEST(RunTest, TheJoinOfOneStepMapsIsFullSlam) {
  const auto world = small_world<TestFixture::kDim>({.seed = 5});
  for (const auto schedule : testing::every<Schedule>()) {
    RunOptions options = this->with(1.0, schedule);
    this->expect_full_slam(world, solve(world.log, options));
    options.polish = false;
    const auto joined = run(world.log, options);
    this->expect_full_slam(world, joined);
    EXPECT_FALSE(joined->polish);
    EXPECT_EQ(joined->local_maps, 0u);
    EXPECT_EQ(joined->raw_segments, 39u);
  }
}

TYPED_TEST(RunTest, CeresGainsNothingFromTheResultNorFromOdometry) {
  const auto world = small_world<TestFixture::kDim>({.poses = 80, .features = 50, .seed = 7});
  const auto result = run(world.log, this->with(8.0));
  ASSERT_TRUE(result);
  for (const auto& start : {this->state_of(*result), testing::odometry_start(world.log)}) {
    EXPECT_NEAR(testing::ceres_optimum(world.log, start).chi2, result->chi2, 1e-8 * result->chi2);
  }
}

TYPED_TEST(RunTest, SessionsTiedByFeaturesAloneAreJoined) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const auto world = small_world<TestFixture::kDim>({.poses = 25, .features = 30, .sessions = 3, .seed = seed});
    ASSERT_EQ(world.log.sessions.size(), 3u);
    for (const auto schedule : testing::every<Schedule>()) {
      SCOPED_TRACE(to_string(schedule));
      this->expect_full_slam(world, run(world.log, this->with(6.0, schedule)));
    }
  }
}

TYPED_TEST(RunTest, ASessionThatIsTiedOnlyToALaterOneIsJoined) {
  // Sessions 0 and 2 share features, and session 1 shares others with session 2 only, so that it meets session 0 last.
  constexpr int kDim = TestFixture::kDim;
  auto world = small_world<kDim>({.poses = 20, .features = 36, .sessions = 3, .seed = 4});
  std::erase_if(world.log.graph.feature_factors, [&](const auto& o) {
    const auto session = world.log.poses[o.base].session;
    return (session == 0 && o.target.value % 2 == 0) || (session == 1 && o.target.value % 2 == 1);
  });
  for (const auto schedule : testing::every<Schedule>()) {
    SCOPED_TRACE(to_string(schedule));
    this->expect_full_slam(world, run(world.log, this->with(5.0, schedule)));
  }
}

TYPED_TEST(RunTest, APoseGraphWithoutFeaturesIsJoined) {
  const auto world = small_world<TestFixture::kDim>({.poses = 60, .features = 0, .closures = 8, .seed = 9});
  for (const double poses : {1.0, 6.0, 20.0}) this->expect_full_slam(world, run(world.log, this->with(poses)));
}

TYPED_TEST(RunTest, ALogOfOnePoseStandsAtTheOrigin) {
  const auto world = small_world<TestFixture::kDim>({.poses = 1, .features = 0, .closures = 0});
  const auto result = run(world.log, RunOptions{});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(local(result->map.poses[0], world.truth.poses[0]).norm(), 0.0);
  EXPECT_EQ(result->chi2, 0.0);
}

TYPED_TEST(RunTest, WhatHoldsNothingIsRefused) {
  constexpr int kDim = TestFixture::kDim;
  Log<kDim> log;
  log.source = "empty.g2o";
  SubmapSet<kDim> set;
  set.source = "empty";
  EXPECT_EQ(testing::error_of(run(log, RunOptions{})), "empty.g2o: there are no poses");
  EXPECT_EQ(testing::error_of(solve(log, RunOptions{})), "empty.g2o: there are no poses");
  EXPECT_EQ(testing::error_of(run(set, RunOptions{})), "empty: there are no poses");
  EXPECT_EQ(testing::error_of(associate(log, AssociationOptions{})), "empty.g2o: there are no poses");
  EXPECT_EQ(testing::error_of(associate(set, AssociationOptions{})), "empty: there are no poses");
  EXPECT_EQ(testing::error_of(find_inliers(log, RobustOptions{})), "empty.g2o: there are no poses");
  EXPECT_EQ(testing::error_of(find_inliers(set, RobustOptions{})), "empty: there are no poses");
  set.poses = PoseIds(std::vector<PoseId>{{0, 1}, {0, 2}});
  set.graph.pose_factors = {{0, 1, {}, PoseMatrix<kDim>::Identity()}};
  EXPECT_EQ(testing::error_of(run(set, RunOptions{})), "empty: pose 1 is in no segment");
}

TYPED_TEST(RunTest, SolveMayStartFromTheValuesOfTheFile) {
  auto world = small_world<TestFixture::kDim>();
  RunOptions options = this->with(1.0);
  options.schedule = Schedule::kBatch;
  options.start = Start::kFile;
  const auto refused = solve(world.log, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("small world: not every pose and feature has a value"), std::string::npos);
  world.log.initial.poses = world.truth.poses;
  world.log.initial.features = world.truth.features;
  const auto result = solve(world.log, options);
  this->expect_full_slam(world, result);
  const double start = log_chi2(world.log, {world.truth.poses, world.truth.features}).total();
  EXPECT_NEAR(result->join.start_chi2, start, 1e-9 * start);
}

TYPED_TEST(RunTest, TheFirstPoseIsHeldWhereTheFileHasIt) {
  constexpr int kDim = TestFixture::kDim;
  auto world = small_world<kDim>();
  testing::Random random(8);
  const Pose<kDim> elsewhere = random.pose<kDim>();
  world.log.initial.poses = moved(elsewhere, world.truth).poses;
  const auto result = run(world.log, this->with(7.0));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->map.gauge, std::vector{PoseIndex(0)});
  EXPECT_LT(local(result->map.poses[0], elsewhere).norm(), 1e-14);
  const Values<kDim> optimum = full_slam(world.log).optimum(world.truth);
  EXPECT_LT(largest_difference(this->state_of(*result), moved(elsewhere, optimum)), 1e-6);
}

TYPED_TEST(RunTest, DegreesOfFreedomAreTheRowsLessTheUnknowns) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  const auto& log = world.log;
  const auto result = run(log, this->with(5.0));
  ASSERT_TRUE(result);
  const auto edges = static_cast<std::int64_t>(log.edges().size());
  const auto rows = edges * kPoseDof<kDim> + static_cast<std::int64_t>(log.observations().size()) * kDim;
  const auto unknowns = static_cast<std::int64_t>((log.poses.size() - 1) * kPoseDof<kDim> + log.features.size() * kDim);
  EXPECT_EQ(result->dof, rows - unknowns);
}

TYPED_TEST(RunTest, DegreesOfFreedomDoNotDependOnTheSplit) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  Log<kDim> held = world.log;
  held.graph.fixed = {{0, world.truth.pose(0)}};
  held.graph.pose_factors.push_back({kWorld, 0, world.truth.pose(0), PoseMatrix<kDim>::Identity()});
  Log<kDim> placed = held;
  placed.graph.feature_factors.push_back({kWorld, 2, world.truth.features[2], PointMatrix<kDim>::Identity()});
  Log<kDim> floating = placed;
  floating.graph.fixed.clear();
  for (const Log<kDim>& log : {world.log, held, placed, floating}) {
    const auto joined_map = run(log, this->with(1.0));
    const auto split = run(log, this->with(5.0));
    ASSERT_TRUE(joined_map && split);
    EXPECT_EQ(joined_map->local_maps, 0U);
    EXPECT_EQ(joined_map->dof, split->dof);
    EXPECT_EQ(joined_map->dof, degrees_of_freedom(log, joined_map->map.gauge.size()));
    EXPECT_EQ(joined_map->dof, degrees_of_freedom(log)) << "which anchors what the join anchors";
  }
}

TYPED_TEST(RunTest, AFeatureThatOnlyTheWorldMentionsIsWhereItSays) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  Log<kDim> log = world.log;
  log.graph.fixed = {{0, world.truth.pose(0)}};
  const FeatureIndex feature = indices(log.features).last;
  log.features.push_back({log.features.back().key + 1});
  const Point<kDim> at = Point<kDim>::Constant(7.0);
  log.graph.feature_factors.push_back({kWorld, feature, at, PointMatrix<kDim>::Identity()});
  Log<kDim> without = world.log;
  without.graph.fixed = log.graph.fixed;
  for (const double poses : {1.0, 5.0}) {
    SCOPED_TRACE(poses);
    RunOptions options = this->with(poses);
    options.covariances = options.marginals = true;
    const auto result = run(log, options);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_LT((result->map.features.back() - at).norm(), 1e-9);
    EXPECT_EQ(result->dof, degrees_of_freedom(log, 1));
    const auto alone = run(without, options);
    EXPECT_NEAR(result->chi2, alone->chi2, 1e-9 * alone->chi2);
    EXPECT_EQ(result->dof, alone->dof);
  }
}

TEST(Run, HeadingsAreWithoutTheTurnsOfTheDrive) {
  LogBuilder<2> builder("circles");
  for (std::uint64_t k = 0; k < 30; ++k) {
    builder.add_pose_edge({0, k}, {0, k + 1}, {Point<2>(1.0, 0.0), Rotation<2>(0.5)}, PoseMatrix<2>::Identity());
  }
  const auto result = run(std::move(builder).finish().value(), RunOptions());
  ASSERT_TRUE(result) << result.error().message;
  const Table<PoseIndex, Pose<2>>& poses = result->map.poses;
  for (const PoseIndex p : indices(poses)) {
    EXPECT_NEAR(poses[p].rotation.angle(), std::remainder(0.5 * p.value, 2.0 * std::numbers::pi), 1e-9);
  }
}

TEST(RunFigures, AJoinThatIsNotPolishedHasConvergedWhereEveryInteriorHas) {
  RunFigures figures;
  EXPECT_TRUE(figures.converged());
  figures.unrecovered = 1;
  EXPECT_FALSE(figures.converged());
  figures.polish.emplace();
  EXPECT_TRUE(figures.converged());
  figures.polish->status = MinimiseStatus::kMaxIterations;
  EXPECT_FALSE(figures.converged());
}

}  // namespace
}  // namespace mapjoin
