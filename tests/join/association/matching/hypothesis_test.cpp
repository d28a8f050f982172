// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <numbers>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// Three known features that are sighted in another order, with errors that are all correlated.
template <typename D>
class HypothesisTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  static constexpr int kPoints = 6;

  HypothesisTest() {
    testing::Random random(2);
    problem_.covariance = 1e-3 * random.template information<kPoints * kDim>();
    for (int k = 0; k < kPoints / 2; ++k) problem_.known.push_back(random.template vector<kDim>());
    for (const Pairing& pairing : pairings_) {
      problem_.sightings.push_back(problem_.known[pairing.known] + random.template vector<kDim>(0.05));
    }
  }

  /// The differences of the first `count` pairings, one after the other.
  Eigen::VectorXd differences(std::size_t count) const {
    Eigen::VectorXd all(static_cast<Eigen::Index>(count) * kDim);
    for (std::size_t k = 0; k < count; ++k) {
      all.segment<kDim>(static_cast<Eigen::Index>(k) * kDim) = problem_.difference(pairings_[k]);
    }
    return all;
  }
  Eigen::MatrixXd covariance_of_differences(std::size_t count) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count) * kDim, problem_.covariance.cols());
    for (std::size_t k = 0; k < count; ++k) {
      const auto row = static_cast<Eigen::Index>(k) * kDim;
      J.block<kDim, kDim>(row, static_cast<Eigen::Index>(pairings_[k].known) * kDim).setIdentity();
      J.block<kDim, kDim>(row, static_cast<Eigen::Index>(problem_.known.size() + pairings_[k].sighting) * kDim) =
          -PointMatrix<kDim>::Identity();
    }
    return J * problem_.covariance * J.transpose();
  }
  double squared_distance(const Eigen::VectorXd& differences) const {
    const auto count = static_cast<std::size_t>(differences.size() / kDim);
    return differences.dot(covariance_of_differences(count).ldlt().solve(differences));
  }

  std::vector<Pairing> pairings_ = {{2, 0}, {0, 1}, {1, 2}};
  PairingProblem<kDim> problem_;
  std::vector<std::vector<Point<kDim>>> sets_ = {{Point<kDim>::Zero(), Point<kDim>::Constant(8.0)}};
  NeighbourDensity<kDim> density_{sets_};
  ChiSquaredQuantiles gates_{0.001};
};
TYPED_TEST_SUITE(HypothesisTest, testing::Dimensions);

TYPED_TEST(HypothesisTest, TheDistanceIsThatOfAllDifferencesTogether) {
  constexpr int kDim = TestFixture::kDim;
  Hypothesis<kDim> hypothesis(this->problem_);
  for (std::size_t k = 0; k < this->pairings_.size(); ++k) {
    const auto extension = hypothesis.extension(this->pairings_[k], this->density_, this->gates_);
    ASSERT_TRUE(extension) << k;
    const double before = hypothesis.squared_distance();
    hypothesis.extend(*extension);
    const double expected = this->squared_distance(this->differences(k + 1));
    EXPECT_NEAR(hypothesis.squared_distance(), expected, 1e-9 * expected);
    EXPECT_NEAR(before + extension->squared_distance(), expected, 1e-9 * expected);
    EXPECT_NEAR(hypothesis.excess(), expected - static_cast<double>((k + 1) * kDim), 1e-8);
  }
  EXPECT_EQ(hypothesis.pairings(), this->pairings_);
  EXPECT_EQ(hypothesis.known_of(0), 2U);
}

TYPED_TEST(HypothesisTest, TakesNoPairingWhoseCovarianceIsNotFinite) {
  this->problem_.covariance.setConstant(std::numeric_limits<double>::infinity());
  const Hypothesis<TestFixture::kDim> hypothesis(this->problem_);
  EXPECT_FALSE(hypothesis.extension(this->pairings_[0], this->density_, this->gates_));
}

TYPED_TEST(HypothesisTest, TheScoreIsTheLikelihoodOfAllDifferencesOverTheDensitiesOfOthers) {
  constexpr int kDim = TestFixture::kDim;
  Hypothesis<kDim> hypothesis(this->problem_);
  double densities = 0.0;
  for (const Pairing& pairing : this->pairings_) {
    const auto extension = hypothesis.extension(pairing, this->density_, this->gates_);
    ASSERT_TRUE(extension);
    const Point<kDim> given_others = extension->covariance.llt().matrixL() * extension->whitened;
    densities += this->density_.log_within(given_others.squaredNorm(), extension->covariance.trace() / kDim);
    hypothesis.extend(*extension);
  }
  const Eigen::VectorXd differences = this->differences(this->pairings_.size());
  const double log_determinant = std::log(this->covariance_of_differences(this->pairings_.size()).determinant());
  const double log_likelihood = -0.5 * (this->squared_distance(differences) + log_determinant +
                                        static_cast<double>(differences.size()) * std::log(2.0 * std::numbers::pi));
  EXPECT_NEAR(hypothesis.score(), log_likelihood - densities, 1e-8);
}

TYPED_TEST(HypothesisTest, KnowsEachPairingGivenAllOthers) {
  constexpr int kDim = TestFixture::kDim;
  Hypothesis<kDim> hypothesis(this->problem_);
  hypothesis.extend_by(this->pairings_, this->density_, this->gates_);
  ASSERT_EQ(hypothesis.pairings(), this->pairings_);
  const auto all_given = hypothesis.given_others(this->density_, this->gates_);
  for (std::size_t k = 0; k < this->pairings_.size(); ++k) {
    std::vector<Pairing> rest = this->pairings_;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
    Hypothesis<kDim> others(this->problem_);
    others.extend_by(rest, this->density_, this->gates_);
    const auto expected = others.extension(this->pairings_[k], this->density_, this->gates_);
    const auto& given = all_given[k];
    ASSERT_TRUE(expected && given) << k;
    EXPECT_NEAR(given->gain, expected->gain, 1e-9);
    EXPECT_LT((given->covariance - expected->covariance).norm(), 1e-9 * expected->covariance.norm());
  }
}

/// Each of three pairings fits those before it, but the first does not fit what the other two say of it.
TYPED_TEST(HypothesisTest, KnowsThatAPairingIsOutsideOfItsGateGivenAllOthers) {
  constexpr int kDim = TestFixture::kDim;
  PairingProblem<kDim> problem;
  const double off = 0.99 * std::sqrt(this->gates_(kDim));
  for (std::size_t k = 0; k < 3; ++k) {
    problem.known.push_back(Point<kDim>::Constant(100.0 * static_cast<double>(k)));
    problem.sightings.push_back(problem.known.back() + (k == 0 ? off : 0.0) * Point<kDim>::Unit(0));
  }
  // Each sighting has an error of its own of variance 0.5; one of variance 1 is common to all.
  problem.covariance.setZero(6 * kDim, 6 * kDim);
  auto of_sightings = problem.covariance.template bottomRightCorner<3 * kDim, 3 * kDim>();
  of_sightings = PointMatrix<kDim>::Identity().replicate(3, 3);
  of_sightings.diagonal().array() += 0.5;
  Hypothesis<kDim> hypothesis(problem);
  hypothesis.extend_by({{0, 0}, {1, 1}, {2, 2}}, this->density_, this->gates_);
  ASSERT_EQ(hypothesis.pairings().size(), 3U);
  const auto given = hypothesis.given_others(this->density_, this->gates_);
  EXPECT_FALSE(given[0]);
  EXPECT_TRUE(given[1]);
}

/// Three pairings fit; two more are off together, by 3.5 deviations of an error that they share: of new features, more
/// probably, but each fits well given the other.
/// Three right pairings, and two wrong ones that fit each other: both are 7 m off, by an error that they have in common.
template <int Dim>
PairingProblem<Dim> problem_of_two_that_fit_each_other() {
  PairingProblem<Dim> problem;
  for (std::size_t k = 0; k < 5; ++k) {
    problem.known.push_back(Point<Dim>::Constant(100.0 * static_cast<double>(k)));
    problem.sightings.push_back(problem.known.back() + (k < 3 ? 0.0 : 7.0) * Point<Dim>::Unit(0));
  }
  problem.covariance = 0.01 * Eigen::MatrixXd::Identity(10 * Dim, 10 * Dim);
  for (std::size_t i = 3; i < 5; ++i) {
    for (std::size_t k = 3; k < 5; ++k) problem.covariance(problem.row_of_sighting(i), problem.row_of_sighting(k)) += 4.0;
  }
  return problem;
}

/// The density of features that stand in a line, one a metre.
template <int Dim>
NeighbourDensity<Dim> density_of_a_line() {
  std::vector<Point<Dim>> line;
  for (int k = 0; k < 50; ++k) line.push_back(static_cast<double>(k) * Point<Dim>::Unit(Dim - 1));
  return NeighbourDensity<Dim>(std::vector<std::vector<Point<Dim>>>{line}, PointMatrix<Dim>::Identity());
}

/// The log density of other features where an extension puts them.
template <int Dim>
double log_others(const Extension<Dim>& extension, const NeighbourDensity<Dim>& density) {
  const Point<Dim> difference = extension.covariance.llt().matrixL() * extension.whitened;
  return density.log_within(difference.squaredNorm(), extension.covariance.trace() / Dim);
}

/// The other features, of which they are if they are wrong, stand where the right ones put them: not within the two's distance.
TYPED_TEST(HypothesisTest, KnowsThatPairingsWhichOnlySupportEachOtherFallTogether) {
  constexpr int kDim = TestFixture::kDim;
  const PairingProblem<kDim> problem = problem_of_two_that_fit_each_other<kDim>();
  const NeighbourDensity<kDim> dense = density_of_a_line<kDim>();
  Hypothesis<kDim> hypothesis(problem);
  hypothesis.extend_by({{0, 0}, {1, 1}, {2, 2}}, dense, this->gates_);
  const auto alone = hypothesis.extension({3, 3}, dense, this->gates_);
  const auto fallen = hypothesis.extension({4, 4}, dense, this->gates_);
  ASSERT_TRUE(alone && fallen);
  ASSERT_LT(fallen->gain, 0.0);
  hypothesis.extend(*fallen);
  const auto given_it = hypothesis.extension({3, 3}, dense, this->gates_);
  ASSERT_TRUE(given_it);
  EXPECT_GT(given_it->gain, 0.0);
  hypothesis.extend(*given_it);
  const auto given = hypothesis.given_others(dense, this->gates_);
  ASSERT_TRUE(given[0] && given[3]);
  const double log_likelihood = given_it->gain + log_others(*given_it, dense) + fallen->gain + log_others(*fallen, dense);
  EXPECT_GT(std::abs(log_others(*alone, dense) - log_others(*given_it, dense)), 0.1);
  EXPECT_NEAR(given[3]->gain, log_likelihood - log_others(*alone, dense) - log_others(*fallen, dense), 1e-9);
  EXPECT_GT(given[0]->gain, 0.0);
}

/// Where a pairing says where a feature is, and nothing else does, nobody knows from how far the other one was overlooked.
TYPED_TEST(HypothesisTest, WhatOnlyTheOtherWrongPairingPutsNearByIsNotOverlooked) {
  constexpr int kDim = TestFixture::kDim;
  std::vector<SightingTrial> trials;
  for (int k = 1; k <= 1000; ++k) trials.emplace_back(0.01 * k, true);
  const SightingChance sees(trials);  // whatever is within 10 m
  PairingProblem<kDim> problem = problem_of_two_that_fit_each_other<kDim>();
  problem.sees = &sees;
  problem.distances.assign(problem.known.size(), {5.0, 5.0});
  const NeighbourDensity<kDim> dense = density_of_a_line<kDim>();
  Hypothesis<kDim> hypothesis(problem);
  hypothesis.extend_by({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}}, dense, this->gates_);
  ASSERT_EQ(hypothesis.pairings().size(), 5u);
  const auto given = hypothesis.given_others(dense, this->gates_);
  problem.sees = nullptr;
  const auto without = hypothesis.given_others(dense, this->gates_);
  ASSERT_TRUE(given[0] && given[3] && without[0] && without[3]);
  EXPECT_NEAR(given[3]->gain, without[3]->gain, 1e-9);
  EXPECT_NEAR(given[0]->gain, without[0]->gain - 2.0 * sees.log_overlooked(5.0, 0.5), 1e-9);
}

TYPED_TEST(HypothesisTest, GrowsAsIfAllKnownFeaturesWereShifted) {
  constexpr int kDim = TestFixture::kDim;
  Hypothesis<kDim> hypothesis(this->problem_);
  hypothesis.extend_by(this->pairings_, this->density_, this->gates_);
  const Point<kDim> shift = Point<kDim>::LinSpaced(0.1, 0.3);
  const Eigen::VectorXd differences = this->differences(this->pairings_.size());
  const Eigen::VectorXd shifted = differences + shift.replicate(static_cast<Eigen::Index>(this->pairings_.size()), 1);
  EXPECT_NEAR(hypothesis.growth()(shift), this->squared_distance(shifted) - this->squared_distance(differences), 1e-8);
}

TYPED_TEST(HypothesisTest, RefusesWhatIsOutsideOfTheGateAlone) {
  constexpr int kDim = TestFixture::kDim;
  this->problem_.sightings[0].x() += 10.0;
  EXPECT_FALSE(Hypothesis<kDim>(this->problem_).extension(this->pairings_[0], this->density_, this->gates_));
}

/// Nine pairings, each just within its own gate, are outside of the gate of all together.
TYPED_TEST(HypothesisTest, RefusesWhatIsOutsideOfTheGateTogether) {
  constexpr int kDim = TestFixture::kDim;
  constexpr std::size_t kCount = 9;
  PairingProblem<kDim> problem;
  const double off = 0.99 * std::sqrt(2.0 * this->gates_(kDim));  // the difference of two points of unit covariance
  for (std::size_t k = 0; k < kCount; ++k) {
    problem.known.push_back(Point<kDim>::Constant(100.0 * static_cast<double>(k)));
    problem.sightings.push_back(problem.known.back() + off * Point<kDim>::Unit(0));
  }
  problem.covariance.setIdentity(2 * kCount * kDim, 2 * kCount * kDim);
  Hypothesis<kDim> hypothesis(problem);
  std::vector<Pairing> all;
  for (std::size_t k = 0; k < kCount; ++k) {
    all.push_back({k, k});
    EXPECT_TRUE(Hypothesis<kDim>(problem).extension(all.back(), this->density_, this->gates_));
  }
  hypothesis.extend_by(all, this->density_, this->gates_);
  EXPECT_FALSE(hypothesis.pairings().empty());
  EXPECT_LT(hypothesis.pairings().size(), kCount);
}

TYPED_TEST(HypothesisTest, TakesEachFeatureAndEachSightingOnce) {
  constexpr int kDim = TestFixture::kDim;
  this->problem_.sightings[1] = this->problem_.sightings[0];
  this->problem_.known[1] = this->problem_.known[2];
  Hypothesis<kDim> hypothesis(this->problem_);
  hypothesis.extend_by({{2, 0}, {2, 1}, {1, 0}}, this->density_, this->gates_);
  EXPECT_EQ(hypothesis.pairings(), (std::vector<Pairing>{{2, 0}}));
  EXPECT_TRUE(hypothesis.takes(2));
  EXPECT_FALSE(hypothesis.takes(1));
  EXPECT_FALSE(hypothesis.known_of(1));
}

}  // namespace
}  // namespace mapjoin
