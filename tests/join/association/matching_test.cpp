// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/association/matching.hpp>
#include <numeric>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using Points = std::vector<Point<2>>;

/// Sightings whose errors are independent but for one shift of all of them.
PairingProblem<2> problem_of(const Points& known, const Points& sightings, double deviation, double deviation_of_shift) {
  PairingProblem<2> problem;
  problem.known = known;
  problem.sightings = sightings;
  problem.surroundings = sightings;
  const auto points = known.size() + sightings.size();
  problem.covariance = Eigen::MatrixXd::Identity(2 * static_cast<Eigen::Index>(points), 2 * static_cast<Eigen::Index>(points));
  problem.covariance *= deviation * deviation;
  for (std::size_t i = known.size(); i < points; ++i) {
    for (std::size_t j = known.size(); j < points; ++j) {
      problem.covariance.block<2, 2>(2 * static_cast<Eigen::Index>(i), 2 * static_cast<Eigen::Index>(j)).diagonal().array() +=
          deviation_of_shift * deviation_of_shift;
    }
  }
  std::vector<std::size_t> all(known.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  problem.choices.assign(sightings.size(), all);
  return problem;
}

Points shifted(Points points, const Point<2>& shift) {
  for (auto& p : points) p += shift;
  return points;
}

const Points kKnown = {{0.0, 0.0}, {1.6, 0.3}, {3.9, -0.4}, {5.2, 2.8}, {1.1, 4.7}, {7.9, 1.2}};

std::vector<Match> matches_of(const PairingProblem<2>& problem, AssociationMethod method = AssociationMethod::kJcbb) {
  const std::vector<Points> sets = {problem.known};
  const NeighbourDensity<2> density(sets);
  return Matcher<2>(density, method, 0.99, 100.0)(problem);
}

TEST(MatcherTest, FindsAShiftTogetherThatMisleadsNearestNeighbours) {
  // Off by a metre together, so that the second feature is seen where the first one is known, nearly.
  const auto problem = problem_of(kKnown, shifted(kKnown, {-1.4, -0.2}), 0.05, 1.0);
  const auto together = matches_of(problem);
  for (std::size_t s = 0; s < kKnown.size(); ++s) {
    EXPECT_EQ(together[s].known, s);
    EXPECT_GT(together[s].probability, 0.99);
  }
  EXPECT_NE(matches_of(problem, AssociationMethod::kNearest)[1].known, 1U);
}

TEST(MatcherTest, SetsAsideWhatCouldBeEitherOfTwo) {
  const auto problem = problem_of({{0.0, 0.0}, {0.5, 0.0}, {4.0, 4.0}, {-3.0, 2.0}}, {{0.25, 0.0}, {4.0, 4.0}}, 0.1, 0.01);
  const auto matches = matches_of(problem);
  EXPECT_LT(matches[0].probability, 0.6);
  EXPECT_EQ(matches[0].candidates, 2U);
  EXPECT_EQ(matches[1].known, 2U);
  EXPECT_GT(matches[1].probability, 0.99);
}

TEST(MatcherTest, LeavesWhatIsFarFromAllWithoutAnyCandidate) {
  const auto matches = matches_of(problem_of(kKnown, {{20.0, 20.0}}, 0.1, 0.1));
  EXPECT_FALSE(matches[0].known);
  EXPECT_EQ(matches[0].candidates, 0U);
}

TEST(MatcherTest, IsNotSureOfAPlaceInARegularPlantationThatItDoesNotKnowToHalfAStep) {
  Points grid;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  // Where it is known well enough all are found, else none though all would fit.
  for (const Match& match : matches_of(problem_of(grid, shifted(grid, {0.2, 0.1}), 0.05, 0.3)))
    EXPECT_GT(match.probability, 0.99);
  for (const Match& match : matches_of(problem_of(grid, shifted(grid, {0.2, 0.1}), 0.05, 2.0)))
    EXPECT_LT(match.probability, 0.9);
}

/// Each coordinate off by at most so much.
Points off_their_places(Points points, double most) {
  testing::Random random(4);
  for (auto& p : points) p += random.vector<2>(most);
  return points;
}

/// Three trees in a corner are known: where others stand like them, those are not known yet.
TEST(MatcherTest, KnowsAPlantationByTreesThatAreSeenWithErrors) {
  Points grid;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  grid = off_their_places(grid, 0.1);
  const Points corner = {grid[0], grid[1], grid[4]};
  auto problem = problem_of(corner, corner, 0.05, 2.0);
  for (const Match& match : matches_of(problem)) EXPECT_GT(match.probability, 0.9);
  problem.surroundings = grid;
  for (const Match& match : matches_of(problem)) EXPECT_LT(match.probability, 0.8);
}

TEST(MatcherTest, IsSureOfAPlaceInAPlantationWhoseTreesStandOffTheirRows) {
  Points trees;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) trees.emplace_back(3.0 * x, 3.0 * y);
  }
  trees = off_their_places(trees, 0.25);
  for (const Match& match : matches_of(problem_of(trees, shifted(trees, {0.2, 0.1}), 0.05, 2.0))) {
    EXPECT_GT(match.probability, 0.99);
  }
}

TEST(MatcherTest, ComparesPlacementsThatExplainFewerOfTheSightings) {
  const Points row = {{0.0, 0.0}, {3.0, 0.0}, {6.0, 0.0}, {9.0, 0.0}};
  auto problem = problem_of(row, row, 0.05, 3.0);
  problem.surroundings.clear();
  for (const Match& match : matches_of(problem)) EXPECT_LT(match.probability, 0.9);
}

TEST(MatcherTest, HasAGateThatNoneOfSoManyDecisionsShouldMiss) {
  // With a confidence of 0.99 in a hundred decisions: 18.4, and 9.2 in one.
  const double away = std::sqrt(14.0 * 2.0) * 0.1;
  const auto problem = problem_of({{0.0, 0.0}, {5.0, 5.0}, {-5.0, 3.0}, {4.0, -6.0}}, {{away, 0.0}}, 0.1, 0.0);
  EXPECT_EQ(matches_of(problem)[0].candidates, 1U);
  EXPECT_EQ(matches_of(problem, AssociationMethod::kNearest)[0].candidates, 0U);
}

TEST(MatcherTest, AsksForMoreWhereChanceHasManyTries) {
  auto problem = problem_of(kKnown, {kKnown[0], kKnown[3], kKnown[4]}, 0.05, 1.0);
  problem.surroundings.clear();
  EXPECT_GT(matches_of(problem)[0].probability, 0.99);
  problem.log_tests = 25.0;
  EXPECT_LT(matches_of(problem)[0].probability, 0.99);
}

TEST(NeighbourDensityTest, KnowsThatFeaturesKeepTheirDistance) {
  Points grid;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  const std::vector<Points> sets(20, grid);
  const NeighbourDensity<2> density(sets);
  EXPECT_NEAR(density.overall(), 1.0 / 9.0, 0.03);
  EXPECT_LT(density.log_within(1.0), std::log(0.01 * density.overall()));
  EXPECT_NEAR(density.log_within(10.0), std::log(density.overall()), 0.5);
}

TEST(NeighbourDensityTest, FallsWithTheVolumeHoweverLargeThatIs) {
  const std::vector<std::vector<Point<3>>> sets = {{Point<3>::Zero(), Point<3>::UnitX()}};
  const NeighbourDensity<3> density(sets);
  EXPECT_NEAR(density.log_within(1e120), density.log_within(1e100) - 60.0 * std::log(10.0), 1e-9);
}

}  // namespace
}  // namespace mapjoin
