// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <tests/join/study/posed_world.hpp>
#include <tests/support/dense_relative.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using testing::DenseRelative;
using testing::PosedWorld;

/// The quadratic share by dense matrices; a row is linear if its Jacobian is the same at two states.
QuadraticShare dense_share(const Eigen::MatrixXd& J, const Eigen::MatrixXd& J_elsewhere, const Eigen::MatrixXd& W) {
  std::vector<Eigen::Index> linear;
  for (Eigen::Index row = 0; row < J.rows(); ++row) {
    if ((J.row(row) - J_elsewhere.row(row)).norm() < 1e-9) linear.push_back(row);
  }
  const Eigen::MatrixXd H = J.transpose() * W * J;
  const Eigen::MatrixXd P = W.inverse();
  const Eigen::MatrixXd M = Eigen::MatrixXd(P(linear, linear)).inverse();
  const Eigen::MatrixXd J_L = J(linear, Eigen::all);
  const Eigen::MatrixXd H_Q = J_L.transpose() * M * J_L;
  return {J.rows(), static_cast<std::int64_t>(linear.size()), H.ldlt().solve(H_Q).trace() / static_cast<double>(J.cols())};
}

class QuadraticShareTest : public ::testing::TestWithParam<double> {};

TEST_P(QuadraticShareTest, IsThatOfRowsWhoseJacobianIsConstant) {
  PosedWorld<2> world(testing::small_world<2>({.poses = 24, .features = 10}).log, GetParam());
  world.problem.linearise();
  ASSERT_FALSE(world.problem.factorise(0.0));
  const DenseRelative<2> here(world.system());
  auto elsewhere = PosedWorld<2>(world.log, GetParam());
  elsewhere.problem.estimate() = world.moved_by(0.4);
  const DenseRelative<2> there(elsewhere.system());
  for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
    const bool is_relative = state == JoinedState::kRelative;
    const Eigen::MatrixXd J = is_relative ? here.J : Eigen::MatrixXd(here.J * here.T.inverse());
    const Eigen::MatrixXd J_elsewhere = is_relative ? there.J : Eigen::MatrixXd(there.J * there.T.inverse());
    const QuadraticShare expected = dense_share(J, J_elsewhere, here.W);
    const QuadraticShare share = quadratic_share(world.system(), state);
    EXPECT_EQ(share.rows, expected.rows);
    EXPECT_EQ(share.quadratic_rows, expected.quadratic_rows);
    EXPECT_NEAR(share.information, expected.information, 1e-8);
    EXPECT_GT(share.information, 0.0);
    EXPECT_LT(share.information, 1.0);
  }
}

INSTANTIATE_TEST_SUITE_P(OfOneStepMapsAndLongerOnes, QuadraticShareTest, ::testing::Values(1.0, 6.0));

template <typename D>
class QuadraticShareInBothDimensions : public ::testing::Test {};
TYPED_TEST_SUITE(QuadraticShareInBothDimensions, testing::Dimensions);

TYPED_TEST(QuadraticShareInBothDimensions, IsAllWhereAllRelationsAreInTheState) {
  PosedWorld<TypeParam::value> world(testing::tree_world<TypeParam::value>(true));
  world.problem.linearise();
  ASSERT_FALSE(world.problem.factorise(0.0));
  const QuadraticShare share = quadratic_share(world.system(), JoinedState::kRelative);
  EXPECT_EQ(share.quadratic_rows, share.rows);
  EXPECT_EQ(share.of_rows(), 1.0);
  EXPECT_NEAR(share.information, 1.0, 1e-9);
}

TYPED_TEST(QuadraticShareInBothDimensions, OfTheRelativeStateCountsTheTree) {
  constexpr int kDim = TypeParam::value;
  PosedWorld<kDim> world(testing::small_world<kDim>({.poses = 20, .features = 10, .closures = 3}).log);
  world.problem.linearise();
  ASSERT_FALSE(world.problem.factorise(0.0));
  const QuadraticShare share = quadratic_share(world.system(), JoinedState::kRelative);
  const auto features = static_cast<std::int64_t>(world.state().features.size());
  const std::int64_t headings = kDim == 2 ? 3 : 0;  // of the closures
  EXPECT_EQ(share.quadratic_rows, 19 * kPoseDof<kDim> + features * kDim + headings);
}

}  // namespace
}  // namespace mapjoin
