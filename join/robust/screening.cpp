// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/join/robust/screening.hpp>
#include <mapjoin/join/robust/selection.hpp>
#include <mapjoin/join/robust/support/sighting_support.hpp>
#include <mapjoin/measure/statistics.hpp>

namespace mapjoin {
namespace {

bool is_outvoted(double odds) {
  return odds < -kLeastOdds;
}

/// The number of closures, observations and repetitions of odometry; at least 1.
template <int Dim>
double doubtful_count_of(const Log<Dim>& log) {
  const std::size_t count = log.closures().size() + log.observations().size() + repeated_odometry(log).size();
  return std::max(1.0, static_cast<double>(count));
}

}  // namespace

template <int Dim>
Screening<Dim>::Screening(const Log<Dim>& log, double confidence, const std::stop_token& stop)
    : chain(log), closures(supported(chain, log.closures(), stop)), doubtful_count(doubtful_count_of(log)) {
  const double tail = (1.0 - confidence) / doubtful_count;
  gates.confidence = confidence;
  gates.widest = {chi_squared_upper_quantile(tail, kPoseDof<Dim>), chi_squared_upper_quantile(tail, Dim)};
  screen_closures();
  screen_observations(log);
}

template <int Dim>
void Screening<Dim>::screen_closures() {
  auto& [support, priors, odds] = closures;
  gates.scale.closures = support.scale(odds);
  if (gates.scale.closures < 1.0) {
    priors = support.priors(gates.scale.closures);
    odds = support.odds(priors, gates.scale.closures);
  }
  outvoted += static_cast<std::size_t>(std::ranges::count_if(odds, is_outvoted));
}

template <int Dim>
void Screening<Dim>::screen_observations(const Log<Dim>& log) {
  const std::vector<double> odds_of_sightings = sighting_odds(chain, log);
  outvoted += static_cast<std::size_t>(std::ranges::count_if(odds_of_sightings, is_outvoted));
  std::vector<double> against;
  for (const double odds_of_one : odds_of_sightings) {
    observations_count.push_back(odds_of_one > kLeastOdds);
    against.push_back(-odds_of_one);
  }
  keep_one_of_each_feature(log, against, observations_count);
}

template struct Screening<2>;
template struct Screening<3>;

}  // namespace mapjoin
