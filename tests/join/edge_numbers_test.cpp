// SPDX-License-Identifier: BSD-3-Clause
// Extreme numbers and logs: the map is exact there, too, or one sentence says why there is none.
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/run.hpp>
#include <numbers>
#include <tests/support/dense_slam.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::full_slam;
using testing::largest_difference;
using testing::small_world;
using testing::SmallWorld;

template <typename D>
class EdgeNumbers : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static RunOptions maps_of(double poses) {
    RunOptions options;
    options.split = {SplitRule::kPoses, poses};
    return options;
  }
  static Values<kDim> state_of(const RunResult<kDim>& result) { return {result.map.poses, result.map.features}; }

  /// Expects the optimum of a dense solver that begins at the truth, with local maps of any length.
  static void expect_optimum(const SmallWorld<kDim>& world) {
    const auto slam = full_slam(world.log);
    const Values<kDim> optimum = slam.optimum(world.truth);
    const double chi2 = slam.linearise(optimum).chi2;
    for (const double poses : {1.0, 5.0, 1000.0}) {
      SCOPED_TRACE(poses);
      const auto result = run(world.log, maps_of(poses));
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_TRUE(result->converged());
      EXPECT_LT(largest_difference(state_of(*result), optimum), 1e-6);
      EXPECT_NEAR(result->chi2, chi2, 1e-9 * chi2 + 1e-12);
    }
  }
  /// A world with `change` applied to each edge and observation.
  template <typename Change>
  static SmallWorld<kDim> changed(SmallWorld<kDim> world, const Change& change) {
    for (auto& o : world.log.graph.pose_factors) change(o);
    for (auto& o : world.log.graph.feature_factors) change(o);
    return world;
  }
  /// A world whose robot takes `path`; each coordinate of odometry and observations is within `noise` of the truth.
  static SmallWorld<kDim> world_of(const std::vector<Pose<kDim>>& path, const std::vector<Point<kDim>>& features, double noise,
                                   double range = 4.0) {
    testing::Random random(11);
    LogBuilder<kDim> builder("world");
    testing::WorldOptions options;
    options.noise = noise;
    options.range = range;
    options.closures = 0;
    testing::record(0, path, features, options, random, builder);
    SmallWorld<kDim> world{std::move(builder).finish().value(), {Table<PoseIndex, Pose<kDim>>(path), {}}};
    for (const FeatureId& id : world.log.features) world.truth.features.push_back(features[id.key]);
    return world;
  }
  /// A path of `poses` poses on a circle, each turn of which has `steps` steps of a metre.
  static std::vector<Pose<kDim>> rounds(int poses, int steps) {
    Pose<kDim> step;
    step.translation[0] = 1.0;
    RotationVector<kDim> turn = RotationVector<kDim>::Zero();
    turn[kRotationDof<kDim> - 1] = 2.0 * std::numbers::pi / steps;
    step.rotation = Rotation<kDim>::exp(turn);
    std::vector<Pose<kDim>> path(1);
    while (static_cast<int>(path.size()) < poses) path.push_back(compose(path.back(), step));
    return path;
  }
};
TYPED_TEST_SUITE(EdgeNumbers, testing::Dimensions);

TYPED_TEST(EdgeNumbers, FiftyTurnsOfOdometryAlone) {
  const auto world = this->world_of(this->rounds(1001, 20), {}, 0.0);
  for (const double poses : {1.0, 30.0}) {
    const auto result = run(world.log, this->maps_of(poses));
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_LT(largest_difference(this->state_of(*result), world.truth), 1e-9);
    EXPECT_LT(result->chi2, 1e-15);
  }
}

TYPED_TEST(EdgeNumbers, WholeTurnsMoreInAHeadingChangeNothing) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>({.reversed_odometry = true});
  auto turned = world;
  int turns = -50;
  for (auto& o : turned.log.graph.pose_factors) {
    RotationVector<kDim> rotation = o.measured.rotation.log();
    rotation += 2.0 * std::numbers::pi * turns++ * (kDim == 2 ? rotation / std::abs(rotation[0]) : rotation.normalized());
    o.measured.rotation = Rotation<kDim>::exp(rotation);
  }
  this->expect_optimum(turned);
  const auto plain = run(world.log, this->maps_of(5.0));
  const auto result = run(turned.log, this->maps_of(5.0));
  ASSERT_TRUE(result && plain);
  EXPECT_LT(largest_difference(this->state_of(*result), this->state_of(*plain)), 1e-9);
}

TEST(EdgeNumbersInThePlane, InitialHeadingsMayHaveTurnedOften) {
  auto world = small_world<2>();
  int turns = -50;
  for (const Pose<2>& pose : world.truth.poses) {
    world.log.initial.poses.push_back(
        {pose.translation, Rotation<2>(pose.rotation.angle() + 2.0 * std::numbers::pi * turns++)});
  }
  world.log.initial.features = world.truth.features;
  RunOptions options;
  options.schedule = Schedule::kBatch;
  options.start = Start::kFile;
  const auto result = solve(world.log, options);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->converged());
  EXPECT_LT(result->join.iterations, 8);
  EXPECT_LT(largest_difference({result->map.poses, result->map.features}, full_slam(world.log).optimum(world.truth)), 1e-6);
}

TYPED_TEST(EdgeNumbers, TenThousandKilometresFromTheOrigin) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  auto far = world;
  Pose<kDim> frame = testing::Random(5).pose<kDim>();
  frame.translation.setConstant(1e7);
  far.log.graph.fixed = {{0, frame}};
  for (const double poses : {1.0, 5.0}) {
    const auto here = run(world.log, this->maps_of(poses));
    const auto there = run(far.log, this->maps_of(poses));
    ASSERT_TRUE(here && there);
    EXPECT_TRUE(there->converged());
    EXPECT_NEAR(there->chi2, here->chi2, 1e-6 * here->chi2);
    Values<kDim> expected = this->state_of(*here);
    for (auto& pose : expected.poses) pose = compose(frame, pose);
    for (auto& feature : expected.features) feature = transform(frame, feature);
    EXPECT_LT(largest_difference(this->state_of(*there), expected), 1e-6);
  }
}

TYPED_TEST(EdgeNumbers, AWorldOfTenThousandKilometres) {
  constexpr int kDim = TestFixture::kDim;
  auto world = this->changed(small_world<kDim>({.noise = 0.0}), [](auto& o) {
    if constexpr (requires { o.measured.translation; }) {
      o.measured.translation *= 1e6;
    } else {
      o.measured *= 1e6;
    }
  });
  for (auto& pose : world.truth.poses) pose.translation *= 1e6;
  for (auto& feature : world.truth.features) feature *= 1e6;
  const auto result = run(world.log, this->maps_of(5.0));
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_LT(largest_difference(this->state_of(*result), world.truth), 1e-6);
}

TYPED_TEST(EdgeNumbers, TheUnitOfInformationDoesNotMatter) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  const auto plain = run(world.log, this->maps_of(5.0));
  ASSERT_TRUE(plain);
  for (const double scale : {1e-11, 1e9}) {  // information from 1e-8 to 1e12
    const auto scaled = this->changed(world, [&](auto& o) { o.information *= scale; });
    const auto result = run(scaled.log, this->maps_of(5.0));
    ASSERT_TRUE(result) << scale << ": " << result.error().message;
    EXPECT_TRUE(result->converged());
    EXPECT_NEAR(result->chi2, scale * plain->chi2, 1e-8 * scale * plain->chi2);
    EXPECT_LT(largest_difference(this->state_of(*result), this->state_of(*plain)), 1e-6);
  }
}

TYPED_TEST(EdgeNumbers, InformationFrom1eMinus8To1e12InOneLogIsExactOrASentence) {
  constexpr int kDim = TestFixture::kDim;
  const auto exact = small_world<kDim>({.noise = 0.0});
  const std::vector<std::pair<double, double>> scales = {{1e-11, 1e9}, {1e9, 1e-11}, {1e-11, 1.0}, {1.0, 1e9}};
  for (const auto& scale : scales) {
    const auto world = this->changed(exact, [&]<typename Factor>(Factor& factor) {
      factor.information *= std::is_same_v<Factor, PoseFactor<kDim>> ? scale.first : scale.second;
    });
    for (const double poses : {1.0, 5.0}) {
      SCOPED_TRACE(::testing::PrintToString(std::pair(scale.first, poses)));
      const auto result = run(world.log, this->maps_of(poses));
      if (!result) {
        EXPECT_NE(result.error().message, "");
        continue;
      }
      EXPECT_TRUE(result->converged());
      EXPECT_LT(largest_difference(this->state_of(*result), exact.truth), 1e-6);
    }
  }
}

TYPED_TEST(EdgeNumbers, FeaturesAtTheRobotsOwnPlace) {
  constexpr int kDim = TestFixture::kDim;
  const auto path = this->rounds(30, 25);
  std::vector<Point<kDim>> features;
  for (std::size_t k = 0; k < path.size(); k += 3) features.push_back(path[k].translation);
  this->expect_optimum(this->world_of(path, features, 0.02));
  this->expect_optimum(this->world_of(path, features, 0.0));
  this->expect_optimum(this->world_of(path, features, 0.0, 1e-6));  // each is seen from its own place only
}

TYPED_TEST(EdgeNumbers, PosesThatNeverMove) {
  constexpr int kDim = TestFixture::kDim;
  testing::Random random;
  std::vector<Point<kDim>> features(4);
  for (auto& feature : features) feature = random.vector<kDim>();
  for (const double noise : {0.0, 0.02}) this->expect_optimum(this->world_of(std::vector<Pose<kDim>>(20), features, noise));
}

TYPED_TEST(EdgeNumbers, NoFeatureAndOneFeature) {
  constexpr int kDim = TestFixture::kDim;
  this->expect_optimum(this->world_of(this->rounds(30, 25), {}, 0.02));
  this->expect_optimum(this->world_of(this->rounds(30, 25), {Point<kDim>::Constant(1.0)}, 0.02));
  this->expect_optimum(small_world<kDim>({.features = 0, .closures = 4}));
}

TYPED_TEST(EdgeNumbers, OnePoseAndWhatItSees) {
  constexpr int kDim = TestFixture::kDim;
  this->expect_optimum(this->world_of(this->rounds(1, 25), {Point<kDim>::Constant(1.0), Point<kDim>::Zero()}, 0.02));
}

}  // namespace
}  // namespace mapjoin
