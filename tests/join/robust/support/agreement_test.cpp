// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/robust/support/agreement.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

double probability(double odds) {
  return 1.0 / (1.0 + std::exp(-odds));
}

/// The log-odds of a measurement with evidence 1 by itself, once others, each of a group and right, have given it `evidence`
/// each.
double odds_among_right_ones(const std::vector<std::uint32_t>& groups, float evidence) {
  std::vector<PriorOdds> priors{{.evidence = 1.0}};
  Agreements agreements(1 + groups.size());
  for (std::uint32_t k = 0; k < groups.size(); ++k) {
    priors.push_back({.is_right = true});
    agreements[0].push_back({k + 1, groups[k], evidence});
  }
  return odds_by_agreement(priors, agreements).front();
}

TEST(OddsByAgreement, AreTheirOwnEvidenceWhereNobodyElseSaysAnything) {
  EXPECT_EQ(odds_by_agreement({{-1.0}, {2.0}}, Agreements(2)), (std::vector<double>{-1.0, 2.0}));
}

TEST(OddsByAgreement, OfTwoThatAgreeLiftEachOther) {
  const std::vector<double> odds = odds_by_agreement({{-1.0}, {-1.0}, {-1.0}}, {{{1, 0, 5.0F}}, {{0, 0, 5.0F}}, {}});
  EXPECT_GT(odds[0], 3.0);
  EXPECT_EQ(odds[0], odds[1]);
  EXPECT_EQ(odds[2], -1.0);
}

TEST(OddsByAgreement, OfOneThatContradictsTwoWhichAgreeFall) {
  const std::vector<double> odds = odds_by_agreement(
      {{0.0}, {0.0}, {0.0}}, {{{1, 0, 5.0F}, {2, 1, -5.0F}}, {{0, 0, 5.0F}, {2, 1, -5.0F}}, {{0, 0, -5.0F}, {1, 0, -5.0F}}});
  EXPECT_GT(odds[0], 3.0);
  EXPECT_GT(odds[1], 3.0);
  EXPECT_LT(odds[2], -6.0);
}

TEST(OddsByAgreement, OfThreeThatAgreeRiseAboveOneThatIsLikelierByItself) {
  const std::vector<double> odds =
      odds_by_agreement({{-3.0}, {-3.0}, {-3.0}, {1.0}}, {{{1, 0, 4.0F}, {2, 1, 4.0F}, {3, 2, -4.0F}},
                                                          {{0, 0, 4.0F}, {2, 1, 4.0F}, {3, 2, -4.0F}},
                                                          {{0, 0, 4.0F}, {1, 1, 4.0F}, {3, 2, -4.0F}},
                                                          {{0, 0, -4.0F}, {1, 1, -4.0F}, {2, 2, -4.0F}}});
  EXPECT_GT(odds[0], 4.0);
  EXPECT_LT(odds[3], -10.0);
}

TEST(OddsByAgreement, AreTheFixedPointOfWhatAllSayByTheirProbabilities) {
  const std::vector<double> odds = odds_by_agreement(
      {{0.5}, {-0.5}, {-1.0}}, {{{1, 0, 1.0F}, {2, 1, -2.0F}}, {{0, 0, 1.0F}, {2, 1, 0.5F}}, {{0, 0, -2.0F}, {1, 1, 0.5F}}});
  EXPECT_NEAR(odds[0], 0.5 + probability(odds[1]) - 2.0 * probability(odds[2]), 1e-6);
  EXPECT_NEAR(odds[1], -0.5 + probability(odds[0]) + 0.5 * probability(odds[2]), 1e-6);
  EXPECT_NEAR(odds[2], -1.0 - 2.0 * probability(odds[0]) + 0.5 * probability(odds[1]), 1e-6);
}

TEST(OddsByAgreement, TakeNoMoreOfAGroupThanOfThreePairs) {
  EXPECT_DOUBLE_EQ(odds_among_right_ones({0, 0, 0}, 5.0F), 16.0);
  EXPECT_DOUBLE_EQ(odds_among_right_ones({0, 0, 0, 0, 0}, 5.0F), 16.0);
  EXPECT_DOUBLE_EQ(odds_among_right_ones({0, 0, 0, 0, 0}, -5.0F), -14.0);
  EXPECT_DOUBLE_EQ(odds_among_right_ones({0, 1, 2, 3, 4}, 5.0F), 26.0);
}

TEST(OddsByAgreement, OfThoseThatCountAsRightOrWrongDoNotChangeWhatTheySay) {
  const std::vector<PriorOdds> priors = {{}, {.evidence = -9.0, .is_right = true}, {.evidence = 9.0, .is_wrong = true}};
  const std::vector<double> odds = odds_by_agreement(priors, {{{1, 0, 4.0F}, {2, 1, 3.0F}}, {}, {}});
  EXPECT_DOUBLE_EQ(odds[0], 4.0);
}

template <typename D>
class EvidenceTest : public ::testing::Test {};
TYPED_TEST_SUITE(EvidenceTest, testing::Dimensions);

TYPED_TEST(EvidenceTest, IsTheLogarithmOfTheDensityTimesTheVolume) {
  constexpr int kSize = kPoseDof<TypeParam::value>;
  testing::Random random;
  const Matrix<kSize> S = random.information<kSize>();
  const Vector<kSize> v = random.vector<kSize>(3.0);
  const double density_at_0 = 1.0 / std::sqrt((2.0 * std::numbers::pi * S).determinant());
  EXPECT_NEAR(evidence<kSize>(Vector<kSize>::Zero(), S, 7.0).at(1.0, 1e3), std::log(7.0 * density_at_0), 1e-9);
  const double chi2 = v.dot(S.inverse() * v);
  EXPECT_NEAR(evidence<kSize>(v, S, 7.0).at(1.0, 1e3), std::log(7.0 * density_at_0) - 0.5 * chi2, 1e-9);
}

TYPED_TEST(EvidenceTest, IsThatOfTheScaledCovariance) {
  constexpr int kSize = kPoseDof<TypeParam::value>;
  testing::Random random;
  const Matrix<kSize> S = random.information<kSize>();
  const Vector<kSize> v = random.vector<kSize>(3.0);
  const Matrix<kSize> scaled = 0.3 * S;
  EXPECT_NEAR(evidence<kSize>(v, S, 7.0).at(0.3, 1e3), evidence<kSize>(v, scaled, 7.0).at(1.0, 1e3), 1e-9);
}

TYPED_TEST(EvidenceTest, IsNeverMoreThanTheMostForOrAgainst) {
  constexpr int kSize = kPoseDof<TypeParam::value>;
  const Matrix<kSize> S = Matrix<kSize>::Identity();
  EXPECT_EQ(evidence<kSize>(Vector<kSize>::Zero(), S, 1e12).at(1.0, 5.0), 5.0);
  EXPECT_EQ(evidence<kSize>(Vector<kSize>::Constant(1e3), S, 1.0).at(1.0, 5.0), -5.0);
}

TYPED_TEST(EvidenceTest, IsNoneWhereTheCovarianceIsNotPositiveDefinite) {
  constexpr int kSize = kPoseDof<TypeParam::value>;
  EXPECT_EQ(evidence<kSize>(Vector<kSize>::Zero(), Matrix<kSize>::Zero(), 1.0).at(1.0, 5.0), 0.0);
}

}  // namespace
}  // namespace mapjoin
