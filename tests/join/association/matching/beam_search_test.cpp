// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/matching/beam_search.hpp>
#include <numeric>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>

namespace mapjoin {
namespace {

/// Features in a cube of 3 m, and sightings of the first of them, moved together by about 0.5 m, with errors of about 0.3 m.
template <int Dim>
PairingProblem<Dim> crowded(unsigned seed) {
  constexpr std::size_t kKnown = 5;
  constexpr std::size_t kSightings = 4;
  testing::Random random(seed);
  PairingProblem<Dim> problem;
  for (std::size_t k = 0; k < kKnown; ++k) problem.known.push_back(random.vector<Dim>(1.5));
  const Point<Dim> shift = random.vector<Dim>(0.5);
  for (std::size_t s = 0; s < kSightings; ++s) {
    problem.sightings.push_back(problem.known[s] + shift + random.vector<Dim>(0.3));
  }
  constexpr Eigen::Index kRows = (kKnown + kSightings) * Dim;
  constexpr Eigen::Index kFirstOfSightings = kKnown * Dim;
  problem.covariance = 0.04 * Eigen::MatrixXd::Identity(kRows, kRows);
  for (Eigen::Index i = kFirstOfSightings; i < kRows; ++i) {
    for (Eigen::Index j = i % Dim + kFirstOfSightings; j < kRows; j += Dim) problem.covariance(i, j) += 0.25;
  }
  std::vector<std::size_t> all(kKnown);
  std::iota(all.begin(), all.end(), std::size_t{0});
  problem.choices.assign(kSightings, all);
  return problem;
}

/// The highest score of all hypotheses that extend one by the sightings from `sighting` on.
template <int Dim>
double highest(const Hypothesis<Dim>& hypothesis, std::size_t sighting, const PairingProblem<Dim>& problem,
               const ForbiddenPairings& forbidden, const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  if (sighting == problem.sightings.size()) return hypothesis.score();
  double most = highest(hypothesis, sighting + 1, problem, forbidden, density, gates);
  for (const std::size_t known : problem.choices[sighting]) {
    if (hypothesis.takes(known) || std::ranges::count(forbidden[sighting], known) > 0) continue;
    const auto extension = hypothesis.extension({known, sighting}, density, gates);
    if (!extension) continue;
    Hypothesis<Dim> longer = hypothesis;
    longer.extend(*extension);
    most = std::max(most, highest(longer, sighting + 1, problem, forbidden, density, gates));
  }
  return most;
}

template <typename D>
class BeamSearch : public ::testing::Test {};
TYPED_TEST_SUITE(BeamSearch, testing::Dimensions);

TYPED_TEST(BeamSearch, FindsTheBestOfAllHypotheses) {
  constexpr int kDim = TypeParam::value;
  std::size_t pairings = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const PairingProblem<kDim> problem = crowded<kDim>(seed);
    const std::vector<std::vector<Point<kDim>>> sets = {problem.known};
    const NeighbourDensity<kDim> density(sets);
    ChiSquaredQuantiles gates(1e-4);
    std::vector<std::size_t> order(problem.sightings.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    ForbiddenPairings forbidden(order.size());
    for (const bool is_first_forbidden : {false, true}) {
      if (is_first_forbidden) forbidden[0].push_back(0);
      const double most = highest(Hypothesis<kDim>(problem), 0, problem, forbidden, density, gates);
      const auto best = best_hypothesis<kDim>(problem, order, forbidden, density, gates);
      pairings += best.pairings().size();
      EXPECT_NEAR(best.score(), most, 1e-9 * std::abs(most)) << seed;
    }
  }
  EXPECT_GT(pairings, 40u) << "of both ways and all seeds";
}

}  // namespace
}  // namespace mapjoin
