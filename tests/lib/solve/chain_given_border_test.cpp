// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <mapjoin/solve/chain_given_border.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using testing::Random;

template <typename D>
class ChainGivenBorderTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kDof = kPoseDof<kDim>;

  /// A random chain with a border, its chain eliminated, and the chain's part of H, dense.
  void make(Eigen::Index length, Eigen::Index border) {
    system = ChainSystem<kDim>(length, border);
    H = Eigen::MatrixXd::Zero(length * kDof, length * kDof);
    E = Eigen::MatrixXd(length * kDof, border);
    for (Eigen::Index k = 0; k < length; ++k) {
      system.diagonal_block(k) = 4.0 * kDof * Matrix<kDof>::Identity() + random.information<kDof>();
      H.block<kDof, kDof>(k * kDof, k * kDof) = system.diagonal_block(k);
      for (auto& entry : E.middleRows<kDof>(k * kDof).reshaped()) entry = random.uniform(-1.0, 1.0);
      system.border_rows(k) = E.middleRows<kDof>(k * kDof);
      if (k + 1 == length) break;
      for (auto& entry : system.coupling(k).reshaped()) entry = random.uniform(-1.0, 1.0);
      H.block<kDof, kDof>(k * kDof, (k + 1) * kDof) = system.coupling(k);
      H.block<kDof, kDof>((k + 1) * kDof, k * kDof) = system.coupling(k).transpose();
    }
    ASSERT_TRUE(system.eliminate_chain());
  }

  Random random;
  ChainSystem<kDim> system{0, 0};
  Eigen::MatrixXd H;
  Eigen::MatrixXd E;
};
TYPED_TEST_SUITE(ChainGivenBorderTest, testing::Dimensions);

TYPED_TEST(ChainGivenBorderTest, FollowsTheBorderAsTheDenseSystemDoes) {
  for (const auto& [length, border] : {std::pair{1, 4}, {6, 5}, {30, 2}}) {
    this->make(length, border);
    const ChainGivenBorder<TestFixture::kDim> chain(this->system);
    const Eigen::MatrixXd expected = -this->H.llt().solve(this->E);
    EXPECT_LT((chain.gain() - expected).norm(), 1e-12 * expected.norm()) << length;
  }
}

TYPED_TEST(ChainGivenBorderTest, HasTheCovarianceOfAnyOfItsPoses) {
  constexpr int kDof = TestFixture::kDof;
  this->make(12, 3);
  const ChainGivenBorder<TestFixture::kDim> chain(this->system);
  const Eigen::MatrixXd inverse = this->H.llt().solve(Eigen::MatrixXd::Identity(12 * kDof, 12 * kDof));
  for (const auto& poses : std::vector<std::vector<Eigen::Index>>{{0}, {11}, {3, 4}, {0, 5, 6, 11}, {}}) {
    std::vector<Eigen::Index> rows;
    for (const Eigen::Index k : poses) {
      for (int i = 0; i < kDof; ++i) rows.push_back(k * kDof + i);
    }
    const Eigen::MatrixXd expected = inverse(rows, rows);
    EXPECT_LE((chain.covariance(poses) - expected).norm(), 1e-12 * expected.norm()) << poses.size();
  }
}

}  // namespace
}  // namespace mapjoin
