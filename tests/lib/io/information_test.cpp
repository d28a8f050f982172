// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/io/information.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

template <typename S>
class InformationTest : public ::testing::Test {
 protected:
  static constexpr int kSize = S::value;

  /// A symmetric matrix with the eigenvalues `smallest`, 1, 2, ... in random directions.
  Matrix<kSize> with_smallest_eigenvalue(double smallest) {
    const Matrix<kSize> Q = random.template information<kSize>().householderQr().householderQ();
    Vector<kSize> eigenvalues;
    for (int i = 0; i < kSize; ++i) eigenvalues[i] = i == 0 ? smallest : i;
    const Matrix<kSize> W = Q * eigenvalues.asDiagonal() * Q.transpose();
    return 0.5 * (W + W.transpose());
  }
  testing::Random random;
};
using Sizes = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>, std::integral_constant<int, 6>>;
TYPED_TEST_SUITE(InformationTest, Sizes);

TYPED_TEST(InformationTest, PassesDefiniteAndSemidefiniteMatricesUnchanged) {
  InformationCheck check(false);
  for (const double smallest : {0.5, 0.0, -1e-10}) {
    auto W = this->with_smallest_eigenvalue(smallest);
    const auto before = W;
    EXPECT_EQ(check.fault(W), std::nullopt) << smallest;
    EXPECT_EQ(W, before);
  }
  Matrix<TestFixture::kSize> zero = Matrix<TestFixture::kSize>::Zero();
  EXPECT_EQ(check.fault(zero), std::nullopt);
}

TYPED_TEST(InformationTest, RefusesAnIndefiniteMatrixOrRepairsAndCountsIt) {
  const auto indefinite = this->with_smallest_eigenvalue(-1e-3);
  auto W = indefinite;
  EXPECT_THAT(InformationCheck(false).fault(W).value_or(""), HasSubstr("is indefinite (eigenvalues from -0.001 to"));
  InformationCheck check(true);
  EXPECT_EQ(check.fault(W), std::nullopt);
  EXPECT_EQ(check.repaired(), 1);
  EXPECT_EQ(check.fault(W), std::nullopt);
  EXPECT_EQ(check.repaired(), 1) << "a repaired matrix passes";
  // The nearest semidefinite matrix is away by the clipped eigenvalue.
  EXPECT_NEAR((W - indefinite).norm(), 1e-3, 1e-12);
}

TYPED_TEST(InformationTest, RefusesANegativeMatrix) {
  Matrix<TestFixture::kSize> W = -Matrix<TestFixture::kSize>::Identity();
  EXPECT_TRUE(InformationCheck(false).fault(W));
}

TYPED_TEST(InformationTest, RefusesWhatIsNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    auto W = this->with_smallest_eigenvalue(1.0);
    W(1, 1) = bad;
    EXPECT_EQ(InformationCheck(true).fault(W), "is not finite");
  }
}

TYPED_TEST(InformationTest, AveragesRoundOffAcrossTheDiagonalAndRefusesMore) {
  auto W = this->with_smallest_eigenvalue(1.0);
  W(0, 1) += 1e-12;
  EXPECT_EQ(InformationCheck(false).fault(W), std::nullopt);
  EXPECT_EQ(W(0, 1), W(1, 0));
  W(0, 1) += 1e-3;
  EXPECT_THAT(InformationCheck(true).fault(W).value_or(""), HasSubstr("is not symmetric"));
}

TYPED_TEST(InformationTest, IsFiniteHoweverLarge) {
  const Matrix<TestFixture::kSize> P = 6e-309 * Matrix<TestFixture::kSize>::Identity();
  const auto W = information_of_covariance<TestFixture::kSize>(P);
  ASSERT_TRUE(W);
  EXPECT_NEAR((*W)(0, 0) / 1e308, 1.0 / 0.6, 1e-9);
}

TYPED_TEST(InformationTest, InvertsADefiniteCovarianceOnly) {
  const auto P = this->with_smallest_eigenvalue(0.5);
  const auto W = information_of_covariance<TestFixture::kSize>(P);
  ASSERT_TRUE(W);
  EXPECT_TRUE((*W * P).isIdentity(1e-12));
  EXPECT_EQ(*W, W->transpose());
  EXPECT_FALSE(information_of_covariance<TestFixture::kSize>(this->with_smallest_eigenvalue(-0.5)));
  EXPECT_FALSE(information_of_covariance<TestFixture::kSize>(Matrix<TestFixture::kSize>::Zero()));
}

}  // namespace
}  // namespace mapjoin
