// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <mapjoin/join/run.hpp>
#include <memory>
#include <numeric>
#include <tests/support/dense_information.hpp>
#include <tests/support/dense_relations.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::DenseInformation;
using testing::small_world;

/// The gauge of the map.
enum class Held { kFirstPose, kTwoPoses, kPriors };

template <typename D>
class MapCovariancesTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  static Log<kDim> world(Held held = Held::kFirstPose) {
    auto small = small_world<kDim>({.poses = 36, .features = 40, .closures = 2, .range = 2.5});
    Log<kDim> log = std::move(small.log);
    testing::Random random(5);
    if (held == Held::kTwoPoses) log.graph.fixed = {{4, small.truth.poses[4]}, {20, small.truth.poses[20]}};
    if (held == Held::kPriors) {
      const Pose<kDim> pose = small.truth.poses[7];
      log.graph.pose_factors.push_back({kWorld, 7, pose, 1e2 * random.information<kDof>()});
      log.graph.feature_factors.push_back({kWorld, 3, small.truth.features[3], 1e2 * random.information<kDim>()});
    }
    return log;
  }
  static RunOptions options(double poses_per_map) {
    RunOptions options;
    options.split = {SplitRule::kPoses, poses_per_map};
    options.covariances = true;
    return options;
  }
  static Values<kDim> state_of(const RunResult<kDim>& result) { return {result.map.poses, result.map.features}; }

  static void add_single_observations(const Log<kDim>& log, DenseInformation<kDim>& dense) {
    for (const auto& o : log.closures()) dense.add(o);
    for (const auto& o : log.pose_priors()) dense.add(o);
    for (const auto& o : log.feature_priors()) dense.add(o);
  }
  static void expect_those_of_the_log(const Log<kDim>& log, const RunResult<kDim>& result) {
    const Values<kDim> state = state_of(result);
    DenseInformation<kDim> dense(state);
    add_single_observations(log, dense);
    for (const auto& o : log.odometry()) dense.add(o);
    for (const auto& o : log.observations()) dense.add(o);
    expect_blocks_of(dense, result);
  }

  static void expect_near(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& expected, const std::string& of) {
    ASSERT_EQ(covariance.rows(), expected.rows());
    EXPECT_LE((covariance - expected).norm(), 1e-9 * expected.norm()) << of;
  }
  /// Expects the marginals of everything and joint covariances of some to be blocks of the inverse of the whole information.
  static void expect_blocks_of(const DenseInformation<kDim>& information, const RunResult<kDim>& result) {
    const auto& map = result.map;
    const Eigen::MatrixXd joined_map = information.inverse(map.gauge);
    const PoseIndex poses_end = indices(map.poses).last;
    const FeatureIndex features_end = indices(map.features).last;
    const auto is_pose = [](const PoseOrFeature& v) { return std::holds_alternative<PoseIndex>(v); };
    const auto row = [&](const PoseOrFeature& v) {
      return is_pose(v) ? information.pose_row(std::get<PoseIndex>(v)) : information.feature_row(std::get<FeatureIndex>(v));
    };
    const auto marginals = result.covariances->marginals();
    ASSERT_TRUE(marginals) << marginals.error().message;
    ASSERT_EQ(marginals->poses.size(), map.poses.size());
    ASSERT_EQ(marginals->features.size(), map.features.size());
    for (const PoseIndex p : indices(map.poses)) {
      expect_near(marginals->poses[p], joined_map.block(row(p), row(p), kDof, kDof), "pose " + std::to_string(p.value));
    }
    for (const FeatureIndex f : indices(map.features)) {
      const Eigen::Index at = row(f);
      expect_near(marginals->features[f], joined_map.block(at, at, kDim, kDim), "feature " + std::to_string(f.value));
    }
    // Every third pose and every second feature, in no order: of one map and of several, kept and eliminated, held and free;
    // and the first pose, which most gauges hold, twice.
    std::vector<PoseOrFeature> some{PoseIndex(0), PoseIndex(0)};
    for (int k = 0; k < poses_end.value; k += 3) some.emplace_back(PoseIndex((k * 7 + 5) % poses_end.value));
    for (int k = 0; k < features_end.value; k += 2) some.emplace_back(FeatureIndex((k * 11 + 3) % features_end.value));
    std::vector<Eigen::Index> rows;
    for (const auto& v : some) {
      for (int i = 0; i < (is_pose(v) ? kDof : kDim); ++i) rows.push_back(row(v) + i);
    }
    const auto joint = result.covariances->joint(some);
    ASSERT_TRUE(joint) << joint.error().message;
    expect_near(*joint, joined_map(rows, rows), "joint");
  }
};
TYPED_TEST_SUITE(MapCovariancesTest, testing::Dimensions);

TYPED_TEST(MapCovariancesTest, OfThePolishedMapAreBlocksOfTheDenseInverseWhateverHoldsIt) {
  for (const Held held : {Held::kFirstPose, Held::kTwoPoses, Held::kPriors}) {
    SCOPED_TRACE(static_cast<int>(held));
    const auto log = this->world(held);
    for (const double poses : {1.0, 6.0, 11.0}) {
      const auto result = run(log, this->options(poses));
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_EQ(result->covariances->estimate(), Estimate::kPolished);
      EXPECT_EQ(result->covariances->anchored(), result->map.gauge);
      this->expect_those_of_the_log(log, *result);
    }
  }
}

TYPED_TEST(MapCovariancesTest, OfFullSlamAreBlocksOfTheDenseInverse) {
  const auto log = this->world();
  const auto result = solve(log, this->options(1.0));
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->covariances->estimate(), Estimate::kPolished);
  this->expect_those_of_the_log(log, *result);
}

TYPED_TEST(MapCovariancesTest, OfJoinedMapsAreBlocksOfTheDenseInverseWithPrivateFeatures) {
  constexpr int kDim = TestFixture::kDim;
  for (const bool has_prior : {false, true}) {
    auto set = testing::small_submap_set(this->world(), 7.0);
    if (has_prior) {
      set.graph.pose_factors.push_back({kWorld, 2, Pose<kDim>{}, 1e2 * testing::Random(3).information<kPoseDof<kDim>>()});
    }
    const auto graph = submap_graph_of(set);
    ASSERT_GT(std::count(graph.is_local.begin(), graph.is_local.end(), true), 2);
    const auto result = run(set, this->options(1.0));
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->covariances->anchored().empty(), has_prior);
    const Values<kDim> state = this->state_of(*result);
    DenseInformation<kDim> dense(state);
    for (const auto& map : set.graph.submaps) dense.add(map);
    for (const auto& closure : set.graph.pose_factors) dense.add(closure);
    this->expect_blocks_of(dense, *result);
    testing::expect_relations_of(dense, result->map.gauge, result->covariances->marginals().value().relations);
  }
}

TYPED_TEST(MapCovariancesTest, OfARecoveredMapAreThoseOfItsWholeLog) {
  const auto log = this->world();
  RunOptions options = this->options(9.0);
  options.polish = false;
  const auto result = run(log, options);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->covariances->estimate(), Estimate::kJoined);
  this->expect_those_of_the_log(log, *result);
}

TYPED_TEST(MapCovariancesTest, OutliveTheirInput) {
  auto log = std::make_unique<Log<TestFixture::kDim>>(this->world());
  auto result = run(*log, this->options(9.0));
  ASSERT_TRUE(result) << result.error().message;
  const auto before = result->covariances->marginals();
  log.reset();
  const auto after = result->covariances->marginals();
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->poses, after->poses);
  EXPECT_EQ(before->features, after->features);
}

TYPED_TEST(MapCovariancesTest, RelativeOnesAreThoseOfTheDifferenceInTheFrameOfTheFirst) {
  constexpr int kDim = TestFixture::kDim;
  constexpr int kDof = kPoseDof<kDim>;
  const auto log = this->world();
  const auto result = run(log, this->options(6.0));
  ASSERT_TRUE(result);
  const auto& covariances = *result->covariances;
  const Values<kDim> state = this->state_of(*result);
  const auto carried = [&](const std::vector<PoseOrFeature>& pair, const auto& f) {
    const Eigen::MatrixXd joint = covariances.joint(pair).value();
    const Eigen::MatrixXd J = testing::numerical_jacobian(f, joint.rows(), 1e-5);
    return Eigen::MatrixXd(J * joint * J.transpose());
  };
  for (const auto& [base, target] : {std::pair<PoseIndex, PoseIndex>{2, 3}, {3, 30}, {0, 17}, {29, 12}}) {
    const Pose<kDim> measured = between(state.pose(base), state.pose(target));
    const auto moved = [&, base = base, target = target](const Eigen::VectorXd& step) {
      return Eigen::VectorXd(local(measured, between(retract(state.pose(base), PoseVector<kDim>(step.head(kDof))),
                                                     retract(state.pose(target), PoseVector<kDim>(step.tail(kDof))))));
    };
    const Eigen::MatrixXd expected = carried({base, target}, moved);
    const auto relative = covariances.relative_pose(base, target);
    ASSERT_TRUE(relative);
    EXPECT_LT((*relative - expected).norm(), 1e-7 * expected.norm()) << base.value << " " << target.value;
  }
  for (const auto& [base, feature] : {std::pair<PoseIndex, FeatureIndex>{5, 8}, {31, 1}, {0, 20}}) {
    const auto moved = [&, base = base, feature = feature](const Eigen::VectorXd& step) {
      return Eigen::VectorXd(transform_into(retract(state.pose(base), PoseVector<kDim>(step.head(kDof))),
                                            Point<kDim>(state.features[feature] + step.template tail<kDim>())));
    };
    const Eigen::MatrixXd expected = carried({base, feature}, moved);
    const auto relative = covariances.relative_feature(base, feature);
    ASSERT_TRUE(relative);
    EXPECT_LT((*relative - expected).norm(), 1e-7 * expected.norm()) << base.value << " " << feature.value;
  }
}

TYPED_TEST(MapCovariancesTest, TheWorldIsCertainAndWhatIsNotInTheMapIsRefused) {
  constexpr int kDof = kPoseDof<TestFixture::kDim>;
  const auto result = run(this->world(Held::kPriors), this->options(6.0));
  ASSERT_TRUE(result);
  const auto& covariances = *result->covariances;
  const auto with_world = covariances.joint(std::vector<PoseOrFeature>{kWorld, PoseIndex(7)}).value();
  const auto marginals = covariances.marginals().value();
  EXPECT_TRUE(with_world.topRows(kDof).isZero(0.0));
  this->expect_near(with_world.bottomRightCorner(kDof, kDof), marginals.poses[7], "pose 7");
  const PoseIndex of_prior = 7;
  ASSERT_EQ(marginals.relations.poses[of_prior].parent, kWorld);
  this->expect_near(covariances.relative_pose(kWorld, of_prior).value(), marginals.relations.poses[of_prior].covariance,
                    "prior");
  const auto error = [&](const PoseOrFeature& of) { return testing::error_of(covariances.joint(std::vector{of})); };
  EXPECT_EQ(error(PoseIndex(36)), "the map has no pose of index 36");
  EXPECT_EQ(error(PoseIndex(-2)), "the map has no pose of index -2");
  EXPECT_EQ(error(FeatureIndex(40)), "the map has no feature of index 40");
  EXPECT_EQ(testing::error_of(covariances.relative_feature(5, 99)), "the map has no feature of index 99");
}

TYPED_TEST(MapCovariancesTest, RelativeOnesDoNotDependOnTheGauge) {
  auto log = this->world();
  const auto options = this->options(6.0);
  const auto first = run(log, options);
  ASSERT_TRUE(first);
  log.graph.fixed = {{25, first->map.poses[25]}};
  const auto later = run(log, options);
  ASSERT_TRUE(later);
  ASSERT_EQ(later->map.gauge, std::vector{PoseIndex(25)});
  const auto a = first->covariances->relative_pose(10, 14);
  const auto b = later->covariances->relative_pose(10, 14);
  ASSERT_TRUE(a && b);
  EXPECT_LT((*a - *b).norm(), 1e-6 * a->norm());
  EXPECT_GT((first->covariances->marginals()->poses[14] - later->covariances->marginals()->poses[14]).norm(), 1e-3 * a->norm());
}

TYPED_TEST(MapCovariancesTest, AreRefusedWhereMemoryDoesNotSuffice) {
  const auto log = this->world();
  RunOptions options = this->options(6.0);
  options.most_memory = 100;
  const auto result = run(log, options);
  ASSERT_TRUE(result);
  const auto marginals = result->covariances->marginals();
  ASSERT_FALSE(marginals);
  EXPECT_EQ(marginals.error().kind, ErrorKind::kTooLarge);
  EXPECT_TRUE(marginals.error().message.starts_with("the covariances of all poses and features would take"));
  const auto joint = result->covariances->joint(std::array<PoseOrFeature, 2>{PoseIndex(3), FeatureIndex(1)});
  ASSERT_FALSE(joint);
  EXPECT_TRUE(joint.error().message.starts_with("the joint covariance of 2 poses and features would take"));
  const auto alone = result->covariances->joint(std::array<PoseOrFeature, 1>{PoseIndex(3)});
  ASSERT_FALSE(alone);
  EXPECT_TRUE(alone.error().message.starts_with("the joint covariance of 1 pose or feature would take"));
}

TYPED_TEST(MapCovariancesTest, AreNotMadeUnlessAskedFor) {
  RunOptions options = this->options(6.0);
  options.covariances = false;
  const auto result = run(this->world(), options);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->covariances);
}

}  // namespace
}  // namespace mapjoin
