// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/dense_information.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class PredictionsTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// A map with the marginals that predict relative poses.
  struct Map {
    explicit Map(Log<kDim> made) : log(std::move(made)) {
      Join<kDim> joined = join(graph, log.poses, log.features, JoinOptions<kDim>{}).value();
      restored.emplace(mapjoin::restored(graph, {}, joined, joined.state));
      restored->system.linearise();
      EXPECT_FALSE(restored->system.factorise(0.0));
      marginals.emplace(restored->system.equations());
    }
    const Values<kDim>& estimate() const { return restored->system.estimate(); }
    /// A closure that is not a part of the map.
    PoseFactor<kDim> closure(PoseIndex base, PoseIndex target) const {
      testing::Random random;
      const Pose<kDim> measured = testing::noisy(between(estimate().poses[base], estimate().poses[target]), 0.1, random);
      return {base, target, measured, 1e2 * random.information<kPoseDof<kDim>>()};
    }
    /// The covariance of the mismatch of a closure, by the dense inverse of all information.
    PoseMatrix<kDim> exact(const PoseFactor<kDim>& closure) const {
      testing::DenseInformation<kDim> dense(estimate());
      for (const auto& o : log.edges()) dense.add(o);
      for (const auto& o : log.observations()) dense.add(o);
      const Eigen::MatrixXd P = dense.inverse({0});
      constexpr int kDof = kPoseDof<kDim>;
      const auto linear = linearise<kDim>(closure.measured, estimate().poses[closure.base], estimate().poses[closure.target]);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kDof, P.rows());
      J.middleCols(dense.pose_row(closure.base), kDof) = linear.J_base;
      J.middleCols(dense.pose_row(closure.target), kDof) = linear.J_target;
      return closure.information.inverse() + PoseMatrix<kDim>(J * P * J.transpose());
    }
    UncertainPose<kDim> mismatch(const PoseFactor<kDim>& closure, const std::stop_token& stop = {}) const {
      return mismatches<kDim>(restored->system, *marginals, std::span(&closure, 1), far, stop).front();
    }
    void expect_exact(PoseIndex base, PoseIndex target) const {
      const PoseFactor<kDim> o = closure(base, target);
      const PoseMatrix<kDim> S = exact(o);
      EXPECT_LT((mismatch(o).covariance - S).norm(), 1e-6 * S.norm()) << base.value << " to " << target.value;
    }

    Log<kDim> log;
    double far = 1e9;
    SubmapGraph<kDim> graph = submap_graph_of(log, split(log, {SplitRule::kPoses, 1.0}), {});
    std::optional<Restored<kDim>> restored;
    std::optional<Marginals> marginals;
  };

  static Log<kDim> world() { return testing::small_world<kDim>({.poses = 24, .features = 10, .closures = 3}).log; }
  /// The log of a line of odometry alone.
  static Log<kDim> line() { return testing::small_world<kDim>({.poses = 24, .features = 0, .closures = 0}).log; }
};
TYPED_TEST_SUITE(PredictionsTest, testing::Dimensions);

TYPED_TEST(PredictionsTest, AreExact) {
  for (const auto& log : {this->world(), this->line()}) {
    const typename TestFixture::Map map(log);
    map.expect_exact(3, 20);
    map.expect_exact(20, 3);
    map.expect_exact(11, 12);
  }
}

TYPED_TEST(PredictionsTest, AreExactFromThePoseThatHoldsTheMap) {
  const typename TestFixture::Map map(this->world());
  map.expect_exact(0, 15);
  map.expect_exact(15, 0);
}

TYPED_TEST(PredictionsTest, AreExactForManyClosuresAtOnce) {
  constexpr int kDim = TypeParam::value;
  const typename TestFixture::Map map(this->world());
  std::vector<PoseFactor<kDim>> closures;
  for (const int target : {23, 7, 16, 2, 11}) closures.push_back(map.closure(5, PoseIndex(target)));
  for (const int base : {22, 14, 9, 1}) closures.push_back(map.closure(PoseIndex(base), 18));
  // More closures from pose 5: one of them to the pose that holds the map, and one to a target of before.
  for (const int target : {20, 0, 7, 3}) closures.push_back(map.closure(5, PoseIndex(target)));
  const auto predicted = mismatches<kDim>(map.restored->system, *map.marginals, closures, map.far);
  for (std::size_t k = 0; k < closures.size(); ++k) {
    const PoseMatrix<kDim> S = map.exact(closures[k]);
    EXPECT_LT((predicted[k].covariance - S).norm(), 1e-6 * S.norm()) << k;
  }
}

TYPED_TEST(PredictionsTest, OfWhatIsFarAreTheLeastCertainThatTheyCanBe) {
  constexpr int kDim = TypeParam::value;
  typename TestFixture::Map map(this->world());
  PoseFactor<kDim> closure = map.closure(3, 20);
  closure.measured.translation[0] += 100.0;
  map.far = 1e9;
  const PoseMatrix<kDim> exact = map.mismatch(closure).covariance;
  map.far = 100.0;
  const UncertainPose<kDim> mismatch = map.mismatch(closure);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<PoseMatrix<kDim>>(mismatch.covariance - exact).eigenvalues().minCoeff(), 0.0);
  const PoseVector<kDim> v = local(Pose<kDim>{}, mismatch.mean);
  EXPECT_GT(v.dot(mismatch.covariance.llt().solve(v)), 100.0);
}

TYPED_TEST(PredictionsTest, MissTheMeasurementByItsResidual) {
  constexpr int kDim = TypeParam::value;
  const typename TestFixture::Map map(this->world());
  const PoseFactor<kDim> closure = map.closure(5, 18);
  const PoseVector<kDim> r =
      residual<kDim>(closure.measured, map.estimate().poses[closure.base], map.estimate().poses[closure.target]);
  EXPECT_GT(r.norm(), 0.01);
  EXPECT_LT((local(Pose<kDim>{}, map.mismatch(closure).mean) - r).norm(), 1e-12);
}

}  // namespace
}  // namespace mapjoin
