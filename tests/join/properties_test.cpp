// SPDX-License-Identifier: BSD-3-Clause
// Invariances of a map: to the order of observations and of local maps, to ids, and to the frame; over random worlds, states
// and schedules (rapidcheck; RC_PARAMS says how many).
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <mapjoin/join/run.hpp>
#include <numeric>
#include <tests/support/dimensions.hpp>
#include <tests/support/every.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::small_world;
using testing::WorldOptions;

constexpr double kSame = 1e-9;  ///< Tolerance relative to chi2, or to the size of the map.

WorldOptions any_world() {
  WorldOptions options;
  options.poses = *rc::gen::inRange(8, 36);
  options.features = *rc::gen::inRange(12, 30);
  options.closures = *rc::gen::inRange(0, 4);
  options.sessions = *rc::gen::inRange(1, 3);
  options.range = 5.0;
  options.noise = *rc::gen::element(0.0, 0.002, 0.01, 0.03);
  options.reversed_odometry = *rc::gen::arbitrary<bool>();
  options.seed = *rc::gen::inRange(0u, 1000000u);
  return options;
}

RunOptions any_run() {
  RunOptions options;
  options.split = {SplitRule::kPoses, static_cast<double>(*rc::gen::inRange(1, 12))};
  options.state = *rc::gen::element(JoinedState::kAbsolute, JoinedState::kRelative);
  options.schedule = *rc::gen::elementOf(testing::every<Schedule>());
  options.solver.relative_chi2 = 1e-11;  // a smaller gain is lost in the rounding of chi2
  options.solver.step_metres = options.solver.step_radians = 1e-11;
  return options;
}

/// A random order of [0, count).
std::vector<std::size_t> any_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  testing::Random random(*rc::gen::inRange(0u, 1000000u));
  for (std::size_t k = count; k > 1; --k) {
    std::swap(order[k - 1], order[static_cast<std::size_t>(random.uniform(0.0, 0.999999 * static_cast<double>(k)))]);
  }
  return order;
}

/// The ids of poses and features, by their index.
struct Names {
  PoseIds poses;
  FeatureIds features;
};

/// The log with `names` as its ids and its factors in random order, pose `held` fixed at `frame`.
template <int Dim>
Log<Dim> said_otherwise(const Log<Dim>& log, const Names& names, PoseIndex held, const Pose<Dim>& frame) {
  LogBuilder<Dim> builder("said otherwise");
  const auto pose = [&](PoseIndex k) { return names.poses[k]; };
  const auto feature = [&](FeatureIndex k) { return names.features[k]; };
  builder.fix(names.poses[held], frame);
  const std::vector<PoseFactor<Dim>> edges(log.edges().begin(), log.edges().end());
  for (const std::size_t k : any_order(edges.size())) {
    const auto& o = edges[k];
    builder.add_pose_edge(pose(o.base), pose(o.target), o.measured, o.information);
  }
  for (const std::size_t k : any_order(log.observations().size())) {
    const auto& o = log.observations()[k];
    builder.add_observation(pose(o.base), feature(o.target), o.measured, o.information);
  }
  return std::move(builder).finish().value();
}

/// The estimates of a map in the order of `names`.
template <int Dim>
Values<Dim> in_order(const GlobalMap<Dim>& map, const Names& names) {
  Values<Dim> state;
  for (const PoseId& id : names.poses) {
    const auto found = std::find(map.pose_ids.begin(), map.pose_ids.end(), id);
    state.poses.push_back(map.poses[PoseIndex(found - map.pose_ids.begin())]);
  }
  for (const FeatureId& id : names.features) {
    const auto found = std::find(map.feature_ids.begin(), map.feature_ids.end(), id);
    state.features.push_back(map.features[FeatureIndex(found - map.feature_ids.begin())]);
  }
  return state;
}

/// The largest difference of two states, relative to the size of the map.
template <int Dim>
double difference(const Values<Dim>& a, const Values<Dim>& b) {
  double size = 1.0;
  for (const auto& pose : a.poses) size = std::max(size, pose.translation.norm());
  return testing::largest_difference(a, b) / size;
}

/// The log of a random world; `names` becomes its ids.
template <int Dim>
Log<Dim> any_log(Names& names) {
  const Log<Dim> log = small_world<Dim>(any_world()).log;
  names = {log.poses, log.features};
  return log;
}

/// The map of a log; a batch join in relative coordinates goes by continuation, which finds the optimum from everywhere.
template <int Dim>
Expected<RunResult<Dim>> map_of(const Log<Dim>& log, RunOptions options) {
  options.gradual = options.schedule == Schedule::kBatch && options.state == JoinedState::kRelative;
  return run(log, options);
}

/// Expects both logs to have the same map, that of `other` moved by `frame`, or neither to have one.
template <int Dim>
void expect_same_map(const Log<Dim>& log, const Names& names, const Log<Dim>& other, const Names& other_names,
                     const Pose<Dim>& frame) {
  const RunOptions options = any_run();
  const auto a = map_of(log, options);
  const auto b = map_of(other, options);
  RC_ASSERT(a.has_value() == b.has_value());
  RC_PRE(a.has_value());
  RC_ASSERT(a->converged());
  RC_ASSERT(b->converged());
  RC_ASSERT(std::abs(a->chi2 - b->chi2) <= kSame * std::max(a->chi2, 1.0));
  Values<Dim> expected = in_order(a->map, names);
  for (auto& pose : expected.poses) pose = compose(frame, pose);
  for (auto& feature : expected.features) feature = transform(frame, feature);
  RC_ASSERT(difference(expected, in_order(b->map, other_names)) <= kSame);
}

template <typename D>
class MapProperty : public ::testing::Test {
 protected:
  /// Seeds rapidcheck, so that the worlds are the same every time, unless the environment does.
  static void SetUpTestSuite() { ::setenv("RC_PARAMS", "seed=1", 0); }
};
TYPED_TEST_SUITE(MapProperty, testing::Dimensions);

TYPED_TEST(MapProperty, TheOrderOfObservationsDoesNotMatter) {
  constexpr int kDim = TypeParam::value;
  EXPECT_TRUE(rc::check([] {
    Names names;
    const Log<kDim> log = any_log<kDim>(names);
    expect_same_map<kDim>(log, names, said_otherwise<kDim>(log, names, 0, {}), names, {});
  }));
}

TYPED_TEST(MapProperty, NamesDoNotMatter) {
  constexpr int kDim = TypeParam::value;
  EXPECT_TRUE(rc::check([] {
    Names names;
    const Log<kDim> log = any_log<kDim>(names);
    Names others = names;
    for (auto& id : others.poses) id.key = 3 * id.key + 17;  // odometry is told from closures by the order of ids
    const auto order = any_order(names.features.size());
    for (std::size_t k = 0; k < order.size(); ++k) others.features[FeatureIndex(k)] = {~std::uint64_t{0} - order[k] * order[k]};
    expect_same_map<kDim>(log, names, said_otherwise<kDim>(log, others, 0, {}), others, {});
  }));
}

TYPED_TEST(MapProperty, TheOrderOfTheMapsDoesNotMatter) {
  constexpr int kDim = TypeParam::value;
  EXPECT_TRUE(rc::check([] {
    Names names;
    const Log<kDim> log = any_log<kDim>(names);
    // Segments of poses are in another order, and with them the local maps; an edge between two of them is a closure then.
    const std::size_t length = *rc::gen::inRange<std::size_t>(2, 12);
    const auto order = any_order(names.poses.size() / length + 1);
    Names others = names;
    for (std::size_t k = 0; k < others.poses.size(); ++k)
      others.poses[PoseIndex(k)] = {0, 100 * order[k / length] + k % length};
    expect_same_map<kDim>(log, names, said_otherwise<kDim>(log, others, 0, {}), others, {});
  }));
}

TYPED_TEST(MapProperty, TheFrameDoesNotMatter) {
  constexpr int kDim = TypeParam::value;
  EXPECT_TRUE(rc::check([] {
    Names names;
    const Log<kDim> log = any_log<kDim>(names);
    testing::Random random(*rc::gen::inRange(0u, 1000000u));
    const Pose<kDim> frame = random.pose<kDim>(20.0, 3.0);
    expect_same_map<kDim>(log, names, said_otherwise<kDim>(log, names, 0, frame), names, frame);
  }));
}

}  // namespace
}  // namespace mapjoin
