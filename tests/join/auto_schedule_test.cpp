// SPDX-License-Identifier: BSD-3-Clause
// Ways of joining that the default schedule takes.
#include <gtest/gtest.h>

#include <mapjoin/join/run.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <numbers>
#include <stop_token>
#include <tests/support/ceres_reference.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A walk whose odometry is `noise` times as noisy as 0.03 m and 0.4 degrees a step.
Simulation<2> noisy_world(std::uint64_t seed, double noise, double feature_cell) {
  ManhattanOptions options;
  options.seed = seed;
  options.feature_cell = feature_cell;
  options.step_noise *= noise;
  options.turn_noise *= noise;
  return simulate_manhattan<2>(options);
}

/// A noisy walk that sees a feature every other step.
Simulation<2> poor_world(std::uint64_t seed, double noise = 20.0) {
  return noisy_world(seed, noise, 7.5);
}

/// The map of `world` by the default schedule; expects it to have the chi2 that Ceres finds from the truth.
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
  EXPECT_EQ(found.join.schedule, Schedule::kAligned);
  EXPECT_LT(found.join.largest_rotation, 1.0);
}

TEST(AutoSchedule, OnlyAlignsWherePosesTurnFarButEveryStepKeepsItsPromise) {
  const auto found = optimum_by_default(noisy_world(1, 30.0, 2.17));
  EXPECT_EQ(found.join.schedule, Schedule::kAligned);
  EXPECT_GT(found.join.largest_rotation, 1.0);
  EXPECT_TRUE(found.join.is_settled);
}

TEST(AutoSchedule, LooksFurtherWhereStepsFallShortOnTheWayToALocalMinimum) {
  const Simulation<2> world = poor_world(9, 15.0);
  const auto aligned = map_by(Schedule::kAligned, world);
  EXPECT_GT(aligned.join.short_steps, 0);
  EXPECT_LT(optimum_by_default(world).chi2, aligned.chi2 - 10.0);
}

/// The number of ways of joining that a run takes, by the default schedule unless `options` ask for another.
int ways_of_default(const Simulation<2>& world, RunOptions options = {}) {
  int ways = 0;
  options.progress = [&](Stage stage, std::size_t done, std::size_t) { ways += stage == Stage::kJoin && done == 1; };
  run(world.log, options).value();
  return ways;
}

TEST(AutoSchedule, EndsWhereTheTreeFindsWhatAligningFound) {
  const Simulation<2> world = poor_world(1);
  EXPECT_GT(map_by(Schedule::kAligned, world).join.short_steps, 0);
  EXPECT_EQ(optimum_by_default(world).join.schedule, Schedule::kAligned);
  EXPECT_EQ(ways_of_default(world), 2);
}

TEST(AutoSchedule, JoinsAlongATreeWhereAligningEndsElsewhere) {
  const Simulation<2> world = poor_world(8);
  const auto found = optimum_by_default(world);
  EXPECT_EQ(found.join.schedule, Schedule::kTree);
  EXPECT_LT(found.chi2, map_by(Schedule::kAligned, world).chi2 - 1.0);
}

TEST(AutoSchedule, DoesNotBelieveTwoWaysThatBothCameFromAfar) {
  const Simulation<2> world = poor_world(21);
  const auto tree = map_by(Schedule::kTree, world);
  EXPECT_NEAR(map_by(Schedule::kAligned, world).chi2, tree.chi2, 1e-3);
  EXPECT_GT(tree.join.largest_rotation, 1.0);
  EXPECT_LT(optimum_by_default(world).chi2, tree.chi2 - 1.0);
}

TEST(AutoSchedule, DoesWithoutMapsOnlyWhereTheyProveCrude) {
  for (const auto& [seed, is_crude] : {std::pair{119, true}, {104, false}}) {
    const Simulation<2> world = poor_world(static_cast<std::uint64_t>(seed));
    const auto found = optimum_by_default(world);
    EXPECT_FALSE(found.join.is_settled);
    EXPECT_EQ(found.recovered_chi2.value() > 1.02 * found.chi2, is_crude);
    EXPECT_EQ(ways_of_default(world), is_crude ? 4 : 3);
  }
}

TEST(AutoSchedule, ConfirmsWhatTwoWaysAgreeOnAndNothingOfOneWay) {
  EXPECT_EQ(run(simulate_manhattan<2>({.poses = 300}).log, RunOptions{})->join.is_confirmed, true);
  EXPECT_EQ(run(poor_world(8).log, RunOptions{})->join.is_confirmed, true);
  EXPECT_EQ(run(poor_world(21).log, RunOptions{})->join.is_confirmed, false);
  EXPECT_EQ(map_by(Schedule::kTree, poor_world(8)).join.is_confirmed, std::nullopt);
}

TEST(AutoSchedule, ConfirmsWhatItEndsAtWithoutMapsOnlyIfThatWasNearOrAsGoodAsLinear) {
  ManhattanOptions options{.poses = 150, .feature_cell = 7.5};
  options.step_noise *= 30.0;
  options.turn_noise *= 30.0;
  // With crude maps no two ways agree on what 30 and 52 end at without; 308 and 471 end at a lower optimum without.
  for (const auto& [seed, is_confirmed] : {std::pair{30, true}, {52, false}, {308, false}, {471, true}}) {
    options.seed = static_cast<std::uint64_t>(seed);
    const Simulation<2> world = simulate_manhattan<2>(options);
    EXPECT_EQ(ways_of_default(world), 4) << seed;
    EXPECT_EQ(run(world.log, RunOptions{})->join.is_confirmed, is_confirmed) << seed;
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

/// A feature that two poses see along the same axis of theirs, which determines it only if their headings differ. A second edge
/// between them, far more certain than the first, says that they do.
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
  EXPECT_NE(found->join.schedule, Schedule::kAligned);
  EXPECT_LT((found->map.features[0] - Point<2>(2.0, 2.0)).norm(), 0.01);
}

/// A drive whose pose 1 sees one feature at two places where it cannot be, one on each side: the curvature of chi2 along its
/// heading is only `share` of that of Gauss-Newton, so that a step goes this share of the way that is left. Odometry starts the
/// heading off by a radian.
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
  EXPECT_GT(found.join.largest_rotation, 0.9);  // from the start, not from where it went on
}

TEST(AutoSchedule, TakesTheWayThatConvergedOfTwoThatAgree) {
  const auto found = by_gauss_newton(creeping_log(5, 0.09), 200);
  EXPECT_EQ(found.join.status, MinimiseStatus::kConverged);
  EXPECT_NE(found.join.schedule, Schedule::kAligned);
}

TEST(AutoSchedule, KeepsTheBestMapWhereNoneFits) {
  auto world = poor_world(1);
  for (auto& o : world.log.graph.pose_factors) o.information *= 100.0;
  for (auto& o : world.log.graph.feature_factors) o.information *= 100.0;
  const auto found = run(world.log, RunOptions{}).value();
  EXPECT_GT(found.join.chi2, 2.0 * static_cast<double>(found.join.dof));
  for (const auto schedule : {Schedule::kAligned, Schedule::kTree, Schedule::kUnbalanced}) {
    EXPECT_LE(found.chi2, map_by(schedule, world).chi2 * (1.0 + 1e-6)) << to_string(schedule);
  }
}

}  // namespace
}  // namespace mapjoin
