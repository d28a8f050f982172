// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/model/information.hpp>
#include <string>
#include <tests/support/random.hpp>
#include <tuple>

namespace mapjoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

template <typename S>
class InformationTest : public ::testing::Test {
 protected:
  static constexpr int kSize = S::value;

  /// A symmetric matrix with the eigenvalues `smallest`, 1, 2, ... along the axes mirrored at a random plane.
  Matrix<kSize> with_smallest_eigenvalue(double smallest) {
    const Vector<kSize> normal = random.template vector<kSize>().normalized();
    const Matrix<kSize> Q = Matrix<kSize>::Identity() - 2.0 * normal * normal.transpose();
    Vector<kSize> eigenvalues;
    for (int i = 0; i < kSize; ++i) eigenvalues[i] = i == 0 ? smallest : i;
    const Matrix<kSize> W = Q * eigenvalues.asDiagonal() * Q;
    return 0.5 * (W + W.transpose());
  }
  testing::Random random;
};
using Sizes = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>, std::integral_constant<int, 6>>;
TYPED_TEST_SUITE(InformationTest, Sizes);

TYPED_TEST(InformationTest, PassesDefiniteAndSemidefiniteMatricesUnchanged) {
  InformationCheck check(false);
  for (const double smallest : {0.5, 0.0, -1e-14}) {
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
  EXPECT_EQ(check.repairs().indefinite, 1);
  EXPECT_EQ(check.fault(W), std::nullopt);
  EXPECT_EQ(check.repairs().indefinite, 1) << "a repaired matrix passes";
  // The nearest semidefinite matrix differs by the clipped eigenvalue.
  EXPECT_NEAR((W - indefinite).norm(), 1e-3, 1e-12);
}

/// `block` beside an entry of 1e9, as planar logs in space have it for height, roll and pitch.
Matrix<3> beside_a_large_entry(const Matrix<2>& block) {
  Matrix<3> W = Matrix<3>::Zero();
  W.topLeftCorner<2, 2>() = block;
  W(2, 2) = 1e9;
  return W;
}

TEST(InformationCheck, RefusesAnIndefiniteBlockBesideAMuchLargerEntryOrRepairsIt) {
  Matrix<2> block;
  for (const auto& [first, across, smallest] : {std::tuple(1.0, 1.9, "-0.9"), {0.0, 0.5, "-0.207"}, {-0.1, 0.0, "-0.1"}}) {
    block << first, across, across, 1.0;
    const Matrix<3> indefinite = beside_a_large_entry(block);
    auto W = indefinite;
    EXPECT_THAT(InformationCheck(false).fault(W).value_or(""),
                AllOf(HasSubstr(std::string("is indefinite (eigenvalues from ") + smallest), HasSubstr(" to 1e+09)")));
    InformationCheck check(true);
    EXPECT_EQ(check.fault(W), std::nullopt);
    EXPECT_EQ(check.fault(W), std::nullopt);
    EXPECT_EQ(check.repairs().indefinite, 1) << "a repaired matrix passes";
    EXPECT_LT((W - indefinite).norm(), 1.0);
  }
}

TEST(InformationCheck, PassesRoundOffOfTheLargestEntryInRowsThatAreNotMeasured) {
  Matrix<2> block;
  block << -1e-6, 1e-6, 1e-6, 0.0;
  auto W = beside_a_large_entry(block);
  EXPECT_EQ(InformationCheck(false).fault(W), std::nullopt);
}

TEST(InformationCheck, PassesASingularBlockBesideAMuchLargerEntry) {
  auto W = beside_a_large_entry(Matrix<2>::Ones());
  EXPECT_EQ(InformationCheck(false).fault(W), std::nullopt);
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

TYPED_TEST(InformationTest, AveragesAFiltersAsymmetryAndCountsItAboveRoundOff) {
  const auto symmetric = this->with_smallest_eigenvalue(1.0);
  const double largest = symmetric.cwiseAbs().maxCoeff();
  for (const auto& [asymmetry, counted] : {std::pair(1e-12, 0), std::pair(1.3e-9, 1), std::pair(0.9e-6, 1)}) {
    auto W = symmetric;
    W(0, 1) += asymmetry * largest;
    InformationCheck check;
    EXPECT_EQ(check.fault(W), std::nullopt) << asymmetry;
    EXPECT_EQ(W, W.transpose());
    EXPECT_NEAR(W(0, 1), symmetric(0, 1) + 0.5 * asymmetry * largest, 1e-14);
    EXPECT_EQ(check.repairs().symmetrised, counted) << asymmetry;
    EXPECT_NEAR(check.repairs().largest_asymmetry, counted * asymmetry, 1e-3 * asymmetry);
  }
}

TYPED_TEST(InformationTest, RefusesMoreAsymmetryOrRepairsIt) {
  auto W = this->with_smallest_eigenvalue(1.0);
  W(0, 1) += 1.1e-6 * W.cwiseAbs().maxCoeff();
  auto P = W;
  EXPECT_THAT(InformationCheck().fault(W).value_or(""), ::testing::EndsWith("differ by up to 1.1e-06 of the largest)"));
  EXPECT_THAT(InformationCheck(false).fault(W).value_or(""), HasSubstr("; --repair-information takes its symmetric part"));
  EXPECT_THAT(InformationCheck(false).invert(P).value_or(""), HasSubstr("; --repair-information takes its symmetric part"));
  InformationCheck check(true);
  EXPECT_EQ(check.fault(W), std::nullopt);
  EXPECT_EQ(W, W.transpose());
  EXPECT_EQ(check.repairs().symmetrised, 1);
  EXPECT_EQ(check.repairs().indefinite, 0);
}

TYPED_TEST(InformationTest, LiftsACovarianceThatIsNotDefiniteWhereItsVariancesArePositive) {
  // Rows in units that differ by a million, which must not matter.
  const Vector<TestFixture::kSize> units = Vector<TestFixture::kSize>::LinSpaced(1e-3, 1e3);
  const Matrix<TestFixture::kSize> singular = units.asDiagonal() * Matrix<TestFixture::kSize>::Ones() * units.asDiagonal();
  auto P = singular;
  EXPECT_THAT(InformationCheck(false).invert(P).value_or(""),
              HasSubstr("is not positive definite; --repair-information takes"));
  InformationCheck check(true);
  EXPECT_EQ(check.invert(P), std::nullopt);
  EXPECT_EQ(check.repairs().indefinite, 1);
  // The information along the one direction of the singular covariance is what it was.
  const Vector<TestFixture::kSize> along = units;
  EXPECT_NEAR(along.dot(P * along), 1.0, 1e-6);
  Matrix<TestFixture::kSize> negative = -Matrix<TestFixture::kSize>::Identity();
  EXPECT_THAT(check.invert(negative).value_or(""), HasSubstr("is not positive definite"));
}

TEST(InformationRank, IsThatOfTheCorrelations) {
  const auto correlated = [](double share) {
    const Eigen::Vector2d units(1e-3, 1e3);
    return Matrix<2>(units.asDiagonal() * (Matrix<2>() << 1.0, share, share, 1.0).finished() * units.asDiagonal());
  };
  EXPECT_EQ(information_rank<2>(correlated(1.0 - 1e-6)), 2);
  EXPECT_EQ(information_rank<2>(correlated(1.0 - 1e-12)), 1);
  EXPECT_EQ(information_rank<2>(Eigen::Vector2d(1e-12, 0.0).asDiagonal()), 1);
}

TEST(InformationRank, OfALocalMapIsUpToTheRoundingOfItsFactorisation) {
  const auto hung_by = [](double softness) {
    const Eigen::Vector3d stiff(1.0, -1.0, 0.0);
    return Eigen::MatrixXd(stiff * stiff.transpose() + softness * Eigen::Matrix3d::Identity());
  };
  EXPECT_EQ(information_rank<Eigen::Dynamic>(hung_by(1e-12)), 3);
  EXPECT_EQ(information_rank<Eigen::Dynamic>(hung_by(0.0)), 1);
}

TYPED_TEST(InformationTest, IdentityIsThatOfTheMeasuredDirections) {
  constexpr int kSize = TestFixture::kSize;
  EXPECT_TRUE(measured_identity<kSize>(this->with_smallest_eigenvalue(1.0)).isIdentity(0.0));
  EXPECT_TRUE(measured_identity<kSize>(Matrix<kSize>::Zero()).isZero(0.0));
  Matrix<kSize> W = this->with_smallest_eigenvalue(1.0);
  W.row(1).setZero();
  W.col(1).setZero();
  Matrix<kSize> but_one = Matrix<kSize>::Identity();
  but_one(1, 1) = 0.0;
  EXPECT_TRUE(measured_identity<kSize>(W).isApprox(but_one, 1e-12));
  EXPECT_TRUE(measured_identity<kSize>(W).row(1).isZero(0.0));
  const Vector<kSize> along = Vector<kSize>::LinSpaced(1e-3, 1e3);
  EXPECT_TRUE(
      measured_identity<kSize>(along * along.transpose()).isApprox(along * along.transpose() / along.squaredNorm(), 1e-12));
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
