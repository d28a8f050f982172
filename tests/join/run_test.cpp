// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <numbers>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
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

  /// The result against the dense optimum of the whole log: every pose and feature, chi2, and no gradient left.
  static void expect_full_slam(const SmallWorld<kDim>& world, const Expected<RunResult<kDim>>& result) {
    ASSERT_TRUE(result) << result.error().message;
    const auto slam = full_slam(world.log);
    const Values<kDim> optimum = slam.optimum(world.truth);
    const Values<kDim> state = state_of(*result);
    EXPECT_TRUE(result->converged());
    EXPECT_LT(largest_difference(state, optimum), 1e-6);
    const double chi2 = slam.linearise(optimum).chi2;
    EXPECT_NEAR(result->chi2, chi2, 1e-9 * chi2);
    EXPECT_EQ(result->chi2, log_chi2(world.log, state).total());
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
    EXPECT_LT(largest_difference(maps.front(), maps.back()), 4e-6) << poses;  // a third of what a join's accuracy leaves
  }
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
  // Sessions 0 and 2 share features, session 1 shares some with session 2 only: it meets the others last.
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
  for (const Log<kDim>& log : {world.log, held, placed}) {
    const auto joined_map = run(log, this->with(1.0));
    const auto split = run(log, this->with(5.0));
    ASSERT_TRUE(joined_map && split);
    EXPECT_EQ(joined_map->local_maps, 0U);
    EXPECT_EQ(joined_map->dof, split->dof);
    EXPECT_EQ(joined_map->dof, degrees_of_freedom(log, joined_map->map.gauge.size()));
  }
}

/// Nobody sees it, but it is in the log, and must not stay where it is not.
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

/// A walk with odometry so many times as noisy as 0.03 m and 0.4 degrees a step.
Simulation<2> noisy_world(std::uint64_t seed, double noise, double feature_cell) {
  ManhattanOptions options;
  options.seed = seed;
  options.feature_cell = feature_cell;
  options.step_noise *= noise;
  options.turn_noise *= noise;
  return simulate_manhattan<2>(options);
}

/// One that sees a feature every other step.
Simulation<2> poor_world(std::uint64_t seed, double noise = 20.0) {
  return noisy_world(seed, noise, 7.5);
}

/// The map of `world` by the default schedule, which is that of least chi2 from the truth.
RunResult<2> optimum_by_default(const Simulation<2>& world) {
  const auto found = run(world.log, RunOptions{}).value();
  const auto from_truth = testing::ceres_optimum(world.log, Values<2>{world.truth.poses, world.truth.features});
  EXPECT_NEAR(found.chi2, from_truth.chi2, 1e-6 * found.chi2);
  return found;
}

RunResult<2> map_by(Schedule schedule, const Simulation<2>& world) {
  RunOptions options;
  options.schedule = schedule;
  return run(world.log, options).value();
}

TEST(AutoSchedule, OnlyAlignsWhereThatIsNearlyLinear) {
  const auto found = optimum_by_default(simulate_manhattan<2>({.poses = 300}));
  EXPECT_EQ(found.schedule, Schedule::kAligned);
  EXPECT_LT(found.largest_rotation, 1.0);
}

TEST(AutoSchedule, OnlyAlignsWherePosesTurnFarButEveryStepKeepsItsPromise) {
  const auto found = optimum_by_default(noisy_world(1, 30.0, 2.17));
  EXPECT_EQ(found.schedule, Schedule::kAligned);
  EXPECT_GT(found.largest_rotation, 1.0);
  EXPECT_TRUE(found.is_settled);
}

TEST(AutoSchedule, LooksFurtherWhereStepsFallShortOnTheWayToALocalMinimum) {
  const Simulation<2> world = poor_world(9, 15.0);
  const auto aligned = map_by(Schedule::kAligned, world);
  EXPECT_GT(aligned.join.short_steps, 0);
  EXPECT_LT(optimum_by_default(world).chi2, aligned.chi2 - 10.0);
}

/// How many ways of joining a run goes along, the default schedule if nothing else is asked for.
int ways_of_default(const Simulation<2>& world, RunOptions options = {}) {
  int ways = 0;
  options.progress = [&](Stage stage, std::size_t done, std::size_t) { ways += stage == Stage::kJoin && done == 1; };
  run(world.log, options).value();
  return ways;
}

TEST(AutoSchedule, EndsWhereTheTreeFindsWhatAligningFound) {
  const Simulation<2> world = poor_world(1);
  EXPECT_GT(map_by(Schedule::kAligned, world).join.short_steps, 0);
  EXPECT_EQ(optimum_by_default(world).schedule, Schedule::kAligned);
  EXPECT_EQ(ways_of_default(world), 2);
}

TEST(AutoSchedule, JoinsAlongATreeWhereAligningEndsElsewhere) {
  const Simulation<2> world = poor_world(8);
  const auto found = optimum_by_default(world);
  EXPECT_EQ(found.schedule, Schedule::kTree);
  EXPECT_LT(found.chi2, map_by(Schedule::kAligned, world).chi2 - 1.0);
}

TEST(AutoSchedule, DoesNotBelieveTwoWaysThatBothCameFromAfar) {
  const Simulation<2> world = poor_world(21);
  const auto tree = map_by(Schedule::kTree, world);
  EXPECT_NEAR(map_by(Schedule::kAligned, world).chi2, tree.chi2, 1e-3);
  EXPECT_GT(tree.largest_rotation, 1.0);
  EXPECT_LT(optimum_by_default(world).chi2, tree.chi2 - 1.0);
}

TEST(AutoSchedule, DoesWithoutMapsOnlyWhereTheyProveCrude) {
  for (const auto& [seed, is_crude] : {std::pair{119, true}, {104, false}}) {
    const Simulation<2> world = poor_world(static_cast<std::uint64_t>(seed));
    const auto found = optimum_by_default(world);
    EXPECT_FALSE(found.is_settled);
    EXPECT_EQ(found.recovered_chi2.value() > 1.02 * found.chi2, is_crude);
    EXPECT_EQ(ways_of_default(world), is_crude ? 4 : 3);
  }
}

TEST(AutoSchedule, DoesWithoutCrudeMapsOnlyWhereNothingElseIsAskedFor) {
  const Simulation<2> world = poor_world(119);
  ASSERT_EQ(ways_of_default(world), 4);
  RunOptions with_split;
  for (const double poses : {5.0, 10.0, 20.0}) {
    with_split.split = {SplitRule::kPoses, poses};
    EXPECT_LE(ways_of_default(world, with_split), 3) << poses;
  }
  RunOptions with_schedule;
  with_schedule.schedule = Schedule::kTree;
  EXPECT_EQ(ways_of_default(world, with_schedule), 1);
}

TEST(AutoSchedule, StopsWhileItDoesWithoutMaps) {
  std::stop_source stop;
  int ways = 0;
  RunOptions options;
  options.progress = [&](Stage stage, std::size_t done, std::size_t) {
    ways += stage == Stage::kJoin && done == 1;
    if (ways == 4) stop.request_stop();
  };
  const auto result = run(poor_world(119).log, options, stop.get_token());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::kInterrupted);
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

/// A feature that two poses see along the same axis of theirs is determined by them where their headings differ, which a
/// closure says against odometry.
TEST(AutoSchedule, GoesOnWhereTheSystemIsSingularAsAlignedOnly) {
  LogBuilder<2> builder("two strips");
  const auto step = [](double heading) { return Pose<2>{{1.0, 0.0}, Rotation<2>(heading)}; };
  for (std::uint64_t pose = 0; pose < 4; ++pose) {
    builder.add_pose_edge({0, pose}, {0, pose + 1}, step(0.0), PoseMatrix<2>::Identity());
  }
  builder.add_pose_edge({0, 0}, {0, 1}, step(0.5 * std::numbers::pi), 1e6 * PoseMatrix<2>::Identity());
  builder.add_observation({0, 0}, {7}, {2.0, 2.0}, PointMatrix<2>::Ones());
  builder.add_observation({0, 1}, {7}, {2.0, -1.0}, PointMatrix<2>::Ones());
  const auto log = std::move(builder).finish().value();
  RunOptions options;
  options.split = {SplitRule::kPoses, 1.0};
  options.schedule = Schedule::kAligned;
  EXPECT_FALSE(run(log, options));
  options.schedule = Schedule::kAuto;
  const auto found = run(log, options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NE(found->schedule, Schedule::kAligned);
  EXPECT_LT((found->map.features[0] - Point<2>(2.0, 2.0)).norm(), 0.01);
}

/// A drive whose pose 1 sees one feature where it cannot be, on both sides: along its heading chi2 curves only `share` of what
/// Gauss-Newton takes it to, and steps go so far of the rest. Odometry is off by a radian.
Log<2> creeping_log(std::uint64_t poses, double share) {
  LogBuilder<2> builder("creeping");
  for (std::uint64_t pose = 1; pose < poses; ++pose) {
    const Eigen::Vector3d information(1e6, 1e6, pose == 1 ? 0.0 : 1e6);
    builder.add_pose_edge({0, pose - 1}, {0, pose}, {{1.0, 0.0}, Rotation<2>(pose == 1 ? 1.0 : 0.0)}, information.asDiagonal());
  }
  builder.add_observation({0, 0}, {7}, {2.0, 0.0}, 1e6 * PointMatrix<2>::Identity());
  for (const double side : {1.0, -1.0}) builder.add_observation({0, 1}, {7}, {share, side}, PointMatrix<2>::Identity());
  return std::move(builder).finish().value();
}

RunResult<2> by_gauss_newton(const Log<2>& log, int max_iterations) {
  RunOptions options;
  options.split = {SplitRule::kPoses, 1.0};
  options.solver.method = Method::kGaussNewton;
  options.solver.max_iterations = max_iterations;
  return run(log, options).value();
}

TEST(AutoSchedule, GoesOnToTheLimitOfIterationsWhereNoWayConverges) {
  const auto found = by_gauss_newton(creeping_log(2, 0.05), 100);
  EXPECT_EQ(found.join.status, MinimiseStatus::kMaxIterations);
  EXPECT_EQ(found.join.iterations, 100);
  EXPECT_GT(found.largest_rotation, 0.9);  // from the start, not from where it went on
}

TEST(AutoSchedule, TakesTheWayThatConvergedOfTwoThatAgree) {
  const auto found = by_gauss_newton(creeping_log(5, 0.09), 200);
  EXPECT_EQ(found.join.status, MinimiseStatus::kConverged);
  EXPECT_NE(found.schedule, Schedule::kAligned);
}

TEST(AutoSchedule, KeepsTheBestMapWhereNoneFits) {
  auto world = poor_world(1);
  for (auto& o : world.log.graph.pose_factors) o.information *= 100.0;
  for (auto& o : world.log.graph.feature_factors) o.information *= 100.0;
  const auto found = run(world.log, RunOptions{}).value();
  EXPECT_GT(found.join.chi2, 2.0 * static_cast<double>(found.join_dof));
  for (const auto schedule : {Schedule::kAligned, Schedule::kTree, Schedule::kUnbalanced}) {
    EXPECT_LE(found.chi2, map_by(schedule, world).chi2 * (1.0 + 1e-6)) << to_string(schedule);
  }
}

}  // namespace
}  // namespace mapjoin
