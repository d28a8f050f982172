// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/join/association/matching/matching.hpp>
#include <numeric>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

using Points = std::vector<Point<2>>;

/// Known features and sightings with independent errors, but for one shift of all sightings.
PairingProblem<2> problem_of(const Points& known, const Points& sightings, double deviation, double deviation_of_shift) {
  PairingProblem<2> problem;
  problem.known = known;
  problem.sightings = sightings;
  problem.maps[1].all = sightings;
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
  // All are off by 1.4 m together, so that the second feature is seen nearly where the first one is known.
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
  // With a shift known to 0.3 m all are sure; known to 2 m only, none is, though all would fit.
  for (const Match& match : matches_of(problem_of(grid, shifted(grid, {0.2, 0.1}), 0.05, 0.3)))
    EXPECT_GT(match.probability, 0.99);
  for (const Match& match : matches_of(problem_of(grid, shifted(grid, {0.2, 0.1}), 0.05, 2.0)))
    EXPECT_LT(match.probability, 0.9);
}

/// The points, each coordinate off by at most `most`.
Points off_their_places(Points points, double most) {
  testing::Random random(4);
  for (auto& p : points) p += random.vector<2>(most);
  return points;
}

/// Three known trees at a corner of a plantation are matched surely if no other trees are in sight, and not if a whole
/// plantation is, where others stand like them.
TEST(MatcherTest, KnowsAPlantationByTreesThatAreSeenWithErrors) {
  Points grid;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  grid = off_their_places(grid, 0.1);
  const Points corner = {grid[0], grid[1], grid[4]};
  auto problem = problem_of(corner, corner, 0.05, 2.0);
  for (const Match& match : matches_of(problem)) EXPECT_GT(match.probability, 0.9);
  problem.maps[1].all = grid;
  for (const Match& match : matches_of(problem)) EXPECT_LT(match.probability, 0.8);
}

/// Of the 160 000 shifts of the trees onto each other the steps near by count, as in a small plantation.
TEST(MatcherTest, KnowsALargePlantation) {
  Points grid;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) grid.emplace_back(3.0 * x, 3.0 * y);
  }
  const Points corner = {grid[0], grid[1], grid[20]};
  auto problem = problem_of(corner, corner, 0.05, 2.0);
  problem.maps[1].all = grid;
  for (const Match& match : matches_of(problem)) {
    EXPECT_LT(match.placement_probability, 0.8);
    EXPECT_LE(match.probability, match.placement_probability);
  }
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
  problem.maps[1].all.clear();
  for (const Match& match : matches_of(problem)) EXPECT_LT(match.probability, 0.9);
}

TEST(MatcherTest, HasAGateThatNoneOfSoManyDecisionsShouldMiss) {
  // The gate is 18.4 with a confidence of 0.99 in a hundred decisions, and 9.2 in one.
  const double away = std::sqrt(14.0 * 2.0) * 0.1;
  const auto problem = problem_of({{0.0, 0.0}, {5.0, 5.0}, {-5.0, 3.0}, {4.0, -6.0}}, {{away, 0.0}}, 0.1, 0.0);
  EXPECT_EQ(matches_of(problem)[0].candidates, 1U);
  EXPECT_EQ(matches_of(problem, AssociationMethod::kNearest)[0].candidates, 0U);
}

TEST(MatcherTest, HasAGateForAnyConfidence) {
  const std::vector<Points> sets(20, kKnown);
  const NeighbourDensity<2> density{std::span(sets)};
  const double tail = 1.0 - (1.0 - 1e-14);
  EXPECT_NEAR(Matcher<2>(density, AssociationMethod::kJcbb, 1.0 - tail, 1e5).gate(), -2.0 * std::log(1e-5 * tail), 1e-6);
}

TEST(MatcherTest, AsksForMoreWhereChanceHasManyTries) {
  auto problem = problem_of(kKnown, {kKnown[0], kKnown[3], kKnown[4]}, 0.05, 1.0);
  problem.maps[1].all.clear();
  EXPECT_GT(matches_of(problem)[0].probability, 0.99);
  problem.log_tests = 25.0;
  EXPECT_LT(matches_of(problem)[0].probability, 0.99);
}

/// A map that sees 0.95 of what is as near to its other features as these are to each other, but not the tree that a known
/// feature's map sees among them.
TEST(MatcherTest, CountsAgainstAPlaceWhatTheMapsOverlookThere) {
  std::vector<SightingTrial> trials;
  for (int k = 0; k < 400; ++k) trials.emplace_back(0.01 * k, true);
  const SightingChance sees(trials);
  auto problem = problem_of(kKnown, shifted(kKnown, {-1.4, -0.2}), 0.05, 1.0);
  problem.maps[0].all = kKnown;
  const std::vector<Points> sets = {kKnown};
  const NeighbourDensity<2> density{std::span(sets)};
  Matcher<2> matcher(density, AssociationMethod::kJcbb, 0.99, 100.0);
  const auto placement = matcher.placements(problem).front();
  ASSERT_EQ(placement.pairings().size(), kKnown.size());
  EXPECT_EQ(matcher.log_odds(problem, placement), placement.score());
  problem.map_sees = &sees;
  EXPECT_EQ(matcher.log_odds(problem, placement), placement.score());
  problem.maps[0].unpaired = {{2.5, 1.5}, {100.0, 100.0}};
  EXPECT_NEAR(matcher.log_odds(problem, placement), placement.score() + std::log(1.0 / 22.0), 1e-9);
  problem.maps[1].unpaired = shifted({{3.0, 1.8}}, {-1.4, -0.2});
  EXPECT_NEAR(matcher.log_odds(problem, placement), placement.score() + 2.0 * std::log(1.0 / 22.0), 1e-9);
}

/// The sightings fit three standard deviations further on, too. Where they fit best, their map would have overlooked two
/// features.
TEST(MatcherTest, IsNotSureOfThePlaceThatFitsBestWhereMapsOverlookMoreThereThanElsewhere) {
  const Points sightings = {kKnown[0], kKnown[1], kKnown[4]};
  Points known = sightings;
  for (const auto& p : shifted(sightings, {7.0, 0.0})) known.push_back(p);
  auto problem = problem_of(known, sightings, 0.05, 7.0 / 3.0);
  problem.maps[0] = {known, {{-1.0, 1.0}, {-1.2, -0.8}}};
  for (const Match& match : matches_of(problem)) EXPECT_GT(match.placement_probability, 0.98);
  std::vector<SightingTrial> trials;
  for (int k = 0; k < 400; ++k) trials.emplace_back(0.01 * k, true);
  const SightingChance sees(trials);
  problem.map_sees = &sees;
  for (const Match& match : matches_of(problem)) EXPECT_LT(match.placement_probability, 0.5);
}

}  // namespace
}  // namespace mapjoin
