// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/dense_relative.hpp>
#include <tests/support/every.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

using testing::DenseRelative;
using testing::largest_difference;

template <int Dim, int PosesPerMap>
struct Joining {
  static constexpr int kDim = Dim;
  static constexpr int kPosesPerMap = PosesPerMap;
};

/// A join of local maps, or of single observations, and closures, some edges stored against their direction, at a state off its
/// optimum.
template <typename J>
class RelativeStateTest : public ::testing::Test {
 protected:
  static constexpr int kDim = J::kDim;

  RelativeStateTest()
      : RelativeStateTest(testing::small_world<kDim>({.poses = 30, .features = 12, .reversed_odometry = true})) {}
  explicit RelativeStateTest(testing::SmallWorld<kDim> world)
      : world_(std::move(world)),
        split_(split(world_.log, {SplitRule::kPoses, J::kPosesPerMap})),
        graph_(submap_graph_of(world_.log, split_, build_local_maps<kDim>(world_.log, split_, {}).value().maps)),
        partial_(joined_map()),
        problem_(partial_, gauge_of(graph_, partial_)) {
    problem_.linearise();
    problem_.factorise(0.0);
    const Eigen::VectorXd step = 0.7 * problem_.solve();
    problem_.try_step(step);
    problem_.accept();
  }

  const JoiningSystem<kDim>& system() { return problem_; }
  static Eigen::VectorXd random_step(Eigen::Index size, double radius) {
    testing::Random random;
    return Eigen::VectorXd::NullaryExpr(size, [&] { return random.uniform(-radius, radius); });
  }
  static void expect_near(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { EXPECT_LT((a - b).norm(), 1e-9 * b.norm()); }

  testing::SmallWorld<kDim> world_;
  Split split_;
  SubmapGraph<kDim> graph_;
  PartialMap<kDim> partial_;
  JoiningSystem<kDim> problem_;

 private:
  PartialMap<kDim> joined_map() const {
    auto joined = join_segments(graph_, {Schedule::kBatch, JoinedState::kAbsolute, {}});
    EXPECT_EQ(joined.partials.size(), 1u);
    place_fixed_poses(graph_, joined.partials.front());
    return std::move(joined.partials.front());
  }
};
using Joinings = ::testing::Types<Joining<2, 6>, Joining<3, 6>, Joining<2, 1>, Joining<3, 1>>;
TYPED_TEST_SUITE(RelativeStateTest, Joinings);

TYPED_TEST(RelativeStateTest, EveryPoseAndFeatureHangsFromWhatCameBefore) {
  const SpanningTree tree = spanning_tree(this->system());
  Table<PoseIndex, bool> stands(this->system().estimate().poses.size(), false);
  stands[0] = true;
  for (const auto& edge : tree.poses) {
    EXPECT_FALSE(stands[edge.child]);
    ASSERT_TRUE(edge.observation);
    EXPECT_TRUE(stands[edge.parent]);
    stands[edge.child] = true;
  }
  EXPECT_EQ(std::count(stands.begin(), stands.end(), false), 0);
  EXPECT_EQ(tree.features.size(), this->system().estimate().features.size());
}

TYPED_TEST(RelativeStateTest, AFeatureHangsFromTheEarliestPoseThatSawIt) {
  Table<FeatureIndex, PoseIndex> earliest(this->system().estimate().features.size(), indices(this->partial_.poses).last);
  for (const auto& o : this->system().feature_factors()) earliest[o.target] = std::min(earliest[o.target], o.base);
  for (const auto& map : this->system().maps()) {
    for (const FeatureIndex f : map.features) earliest[f] = std::min(earliest[f], map.base);
  }
  for (const auto& edge : spanning_tree(this->system()).features) EXPECT_EQ(edge.parent, earliest[edge.child]);
}

TYPED_TEST(RelativeStateTest, TheDenseReferenceAgreesWithCentralDifferences) {
  constexpr int kDim = TestFixture::kDim;
  const DenseRelative<kDim> dense(this->system());
  const Values<kDim>& estimate = this->system().estimate();
  const auto absolute = [&](const Eigen::VectorXd& step) {
    const Values<kDim> moved = dense.moved(step);
    Eigen::VectorXd x(dense.T.rows());
    for (PoseIndex p = 1; p < indices(moved.poses).last; ++p) {
      const auto entry = (p - 1).value * kPoseDof<kDim>;
      x.template segment<kPoseDof<kDim>>(entry) = local(estimate.poses[p], moved.poses[p]);
    }
    const auto first = static_cast<Eigen::Index>(moved.poses.size() - 1) * kPoseDof<kDim>;
    for (const FeatureIndex f : indices(moved.features)) {
      x.template segment<kDim>(first + f.value * kDim) = moved.features[f];
    }
    return x;
  };
  const Eigen::MatrixXd T = testing::numerical_jacobian(absolute, dense.T.cols());
  EXPECT_LT((T - dense.T).norm(), 1e-6 * T.norm());
}

TYPED_TEST(RelativeStateTest, TheGaussNewtonStepIsThatOfTheDenseRelativeSystem) {
  const DenseRelative<TestFixture::kDim> dense(this->system());
  RelativeJoin<TestFixture::kDim> relative(this->problem_);
  relative.linearise();
  ASSERT_FALSE(relative.factorise(0.0));
  this->expect_near(relative.solve(), dense.T * dense.H.ldlt().solve(dense.g));
}

TYPED_TEST(RelativeStateTest, LevenbergMarquardtDampsTheRelations) {
  const DenseRelative<TestFixture::kDim> dense(this->system());
  RelativeJoin<TestFixture::kDim> relative(this->problem_);
  relative.linearise();
  for (const double damping : {1e-3, 1.0, 1e3, 0.0}) {
    ASSERT_FALSE(relative.factorise(damping));
    this->expect_near(relative.solve(), dense.T * (dense.H + damping * dense.D).ldlt().solve(dense.g));
  }
}

TYPED_TEST(RelativeStateTest, TheDoglegMeasuresAndDescendsInRelations) {
  const DenseRelative<TestFixture::kDim> dense(this->system());
  RelativeJoin<TestFixture::kDim> relative(this->problem_);
  relative.linearise();
  const Eigen::VectorXd descent = dense.D.ldlt().solve(dense.g);
  this->expect_near(relative.metric().descent(relative.gradient()), dense.T * descent);
  EXPECT_NEAR(relative.curvature(dense.T * descent), descent.dot(dense.H * descent), 1e-9 * descent.dot(dense.H * descent));
  const Eigen::VectorXd a = this->random_step(dense.T.cols(), 1.0);
  const double lengths = std::sqrt(a.dot(dense.D * a) * descent.dot(dense.D * descent));
  EXPECT_NEAR(relative.metric().inner(dense.T * a, dense.T * descent), a.dot(dense.D * descent), 1e-9 * lengths);
}

TYPED_TEST(RelativeStateTest, AStepMovesTheRelationsAndComposesThemAgain) {
  constexpr int kDim = TestFixture::kDim;
  const DenseRelative<kDim> dense(this->system());
  RelativeState<kDim> relative(this->system());
  relative.linearise(this->system());
  const Eigen::VectorXd step = this->random_step(dense.T.cols(), 0.5);
  EXPECT_LT(largest_difference(relative.retracted(this->system(), dense.T * step), dense.moved(step)), 1e-9);
}

TYPED_TEST(RelativeStateTest, BothStatesHaveOneOptimum) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = testing::small_world<kDim>({.poses = 60, .features = 30, .closures = 6, .sessions = 2});
  RunOptions options;
  options.split = {SplitRule::kPoses, TypeParam::kPosesPerMap};
  for (const auto method : testing::every<Method>()) {
    // One method for both, for local maps of two methods differ in their last digits.
    options.solver.method = method;
    options.state = JoinedState::kAbsolute;
    options.schedule = Schedule::kAuto;
    const auto absolute = run(world.log, options);
    ASSERT_TRUE(absolute) << absolute.error().message;
    for (const auto schedule : testing::every<Schedule>()) {
      options.state = JoinedState::kRelative;
      options.schedule = schedule;
      const auto relative = run(world.log, options);
      ASSERT_TRUE(relative) << relative.error().message;
      EXPECT_TRUE(relative->converged());
      EXPECT_NEAR(relative->join.chi2, absolute->join.chi2, 1e-8 * absolute->join.chi2) << to_string(method);
      EXPECT_NEAR(relative->chi2, absolute->chi2, 1e-9 * absolute->chi2);
    }
  }
}

/// Two robots that features alone tie to each other, held by priors of a later pose and of a feature.
template <typename J>
class RelativeStateInTheWorldTest : public RelativeStateTest<J> {
 protected:
  static constexpr int kDim = J::kDim;

  RelativeStateInTheWorldTest() : RelativeStateTest<J>(world_with_priors()) {}

 private:
  static testing::SmallWorld<kDim> world_with_priors() {
    auto world = testing::small_world<kDim>({.poses = 15, .features = 12, .sessions = 2, .reversed_odometry = true});
    testing::Random random(5);
    world.log.graph.pose_factors.push_back({kWorld, 7, world.truth.poses[7], 1e2 * random.information<kPoseDof<kDim>>()});
    world.log.graph.feature_factors.push_back({kWorld, 3, world.truth.features[3], 1e2 * random.information<kDim>()});
    return world;
  }
};
TYPED_TEST_SUITE(RelativeStateInTheWorldTest, Joinings);

TYPED_TEST(RelativeStateInTheWorldTest, StepsAreThoseOfTheDenseRelativeSystem) {
  constexpr int kDim = TestFixture::kDim;
  this->problem_.linearise();
  const DenseRelative<kDim> dense(this->system());
  RelativeJoin<kDim> relative(this->problem_);
  relative.linearise();
  for (const double damping : {0.0, 1e-2, 10.0, 0.0}) {
    ASSERT_FALSE(relative.factorise(damping));
    this->expect_near(relative.solve(), dense.T * (dense.H + damping * dense.D).ldlt().solve(dense.g));
  }
  relative.linearise();
  this->expect_near(relative.metric().descent(relative.gradient()), dense.T * dense.D.ldlt().solve(dense.g));
  const Eigen::VectorXd step = this->random_step(dense.T.cols(), 0.5);
  EXPECT_LT(largest_difference(relative.metric().retracted(this->system(), dense.T * step), dense.moved(step)), 1e-9);
}

}  // namespace
}  // namespace mapjoin
