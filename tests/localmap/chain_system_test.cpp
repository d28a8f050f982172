// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/localmap/chain_system.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

template <typename D>
class ChainSystemTest : public ::testing::Test {
 protected:
  static constexpr int kDof = kPoseDof<D::value>;

  /// Makes a random chain of `length` poses with `border` further entries, and the dense matrix that equals it.
  void make(Eigen::Index length, Eigen::Index border) {
    system = ChainSystem<D::value>(length, border);
    const Eigen::Index chain = length * kDof;
    const Eigen::Index size = chain + border;
    // Jacobians of observations that tie a pose to its neighbour and to the whole border.
    dense = Eigen::MatrixXd::Identity(size, size);
    for (Eigen::Index k = 0; k < length; ++k) {
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kDof, size);
      for (auto& entry : J.middleCols(k * kDof, std::min<Eigen::Index>(2, length - k) * kDof).reshaped()) {
        entry = random.uniform(-1.0, 1.0);
      }
      for (auto& entry : J.rightCols(border).reshaped()) entry = random.uniform(-1.0, 1.0);
      dense += J.transpose() * J;
    }
    for (Eigen::Index k = 0; k < length; ++k) {
      system.diagonal_block(k) = dense.block<kDof, kDof>(k * kDof, k * kDof);
      if (k + 1 < length) system.coupling(k) = dense.block<kDof, kDof>(k * kDof, (k + 1) * kDof);
      if (border > 0) system.border_rows(k) = dense.block(k * kDof, chain, kDof, border);
    }
    system.border().template triangularView<Eigen::Upper>() = dense.bottomRightCorner(border, border);
    for (auto& entry : system.gradient()) entry = random.uniform(-1.0, 1.0);
  }
  Eigen::VectorXd random_vector() {
    Eigen::VectorXd v(system.size());
    for (auto& entry : v) entry = random.uniform(-1.0, 1.0);
    return v;
  }
  Eigen::VectorXd solution() {
    ChainSystem<D::value> eliminated = system;
    EXPECT_TRUE(eliminated.eliminate_chain());
    const Eigen::Index border = eliminated.border_size();
    const Eigen::MatrixXd schur = eliminated.border().template selfadjointView<Eigen::Upper>();
    const Eigen::VectorXd border_step = schur.llt().solve(Eigen::VectorXd(eliminated.gradient().tail(border)));
    Eigen::VectorXd x(eliminated.size());
    x << eliminated.chain_step(border_step), border_step;
    return x;
  }

  Random random;
  ChainSystem<D::value> system{0, 0};
  Eigen::MatrixXd dense;
};
TYPED_TEST_SUITE(ChainSystemTest, testing::Dimensions);

TYPED_TEST(ChainSystemTest, SolvesLikeTheDenseSystem) {
  for (const auto& [length, border] : {std::pair{1, 0}, {1, 4}, {5, 0}, {0, 6}, {7, 9}, {30, 3}}) {
    this->make(length, border);
    const Eigen::VectorXd expected = this->dense.llt().solve(this->system.gradient());
    EXPECT_LT((this->solution() - expected).norm(), 1e-11 * (1.0 + expected.norm())) << length << " poses, border " << border;
  }
}

TYPED_TEST(ChainSystemTest, EliminationLeavesTheSchurComplement) {
  this->make(6, 5);
  const Eigen::Index chain = this->system.size() - 5;
  const Eigen::MatrixXd E = this->dense.topRightCorner(chain, 5);
  const Eigen::MatrixXd expected =
      this->dense.bottomRightCorner(5, 5) - E.transpose() * this->dense.topLeftCorner(chain, chain).llt().solve(E);
  ASSERT_TRUE(this->system.eliminate_chain());
  const Eigen::MatrixXd schur = this->system.border().template selfadjointView<Eigen::Upper>();
  EXPECT_LT((schur - expected).norm(), 1e-11 * expected.norm());
}

TYPED_TEST(ChainSystemTest, CurvatureAndDiagonalAreThoseOfTheDenseMatrix) {
  this->make(4, 6);
  const Eigen::VectorXd v = this->random_vector();
  EXPECT_NEAR(this->system.curvature(v), v.dot(this->dense * v), 1e-11 * v.dot(this->dense * v));
  EXPECT_EQ((this->system.diagonal() - this->dense.diagonal()).norm(), 0.0);
}

TYPED_TEST(ChainSystemTest, DampingScalesTheDiagonalAlone) {
  this->make(4, 6);
  this->system.damp(0.3);
  this->dense.diagonal() *= 1.3;
  const Eigen::VectorXd expected = this->dense.llt().solve(this->system.gradient());
  EXPECT_LT((this->solution() - expected).norm(), 1e-11 * expected.norm());
}

TYPED_TEST(ChainSystemTest, SaysThatAChainPoseIsNotDetermined) {
  this->make(3, 2);
  this->system.diagonal_block(1).setZero();
  EXPECT_FALSE(this->system.eliminate_chain());
}

TYPED_TEST(ChainSystemTest, APoseThatOnlyRoundingDeterminesIsNotDetermined) {
  constexpr int kDof = TestFixture::kDof;
  this->make(2, 0);
  this->system.coupling(0).setZero();
  // A pose block that is singular along (1, -1, 0, …) but for the last digit.
  this->system.diagonal_block(1) = 1e4 * Matrix<kDof>::Identity();
  this->system.diagonal_block(1)(0, 1) = this->system.diagonal_block(1)(1, 0) = 1e4 * (1.0 - 1e-16);
  EXPECT_FALSE(this->system.eliminate_chain());
}

}  // namespace
}  // namespace mapjoin
