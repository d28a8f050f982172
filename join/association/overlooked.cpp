// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mapjoin/join/association/overlooked.hpp>

namespace mapjoin {
namespace {

/// The distance of the nearest of some points (m); infinite if there are none.
template <int Dim>
double distance_of_nearest(const Point<Dim>& from, const std::vector<Point<Dim>>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& point : points) least = std::min(least, (point - from).norm());
  return least;
}

/// The difference of the pairing whose place in its map, as `place_of` gives it, is nearest to a point (m).
template <int Dim, typename PlaceOf>
Point<Dim> nearest_difference(const Point<Dim>& point, const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                              const PlaceOf& place_of) {
  const auto distance = [&](const Pairing& pairing) { return (place_of(pairing) - point).squaredNorm(); };
  return problem.difference(*std::ranges::min_element(placement.pairings(), {}, distance));
}

/// The features of each map without partner: those that can have none, and those for which no choice fits the placement.
template <int Dim>
std::array<std::vector<Point<Dim>>, 2> without_partner(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                                                       const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  std::array<std::vector<Point<Dim>>, 2> alone{problem.maps[0].unpaired, problem.maps[1].unpaired};
  std::vector<bool> has_partner(problem.known.size(), false);
  for (std::size_t s = 0; s < problem.sightings.size(); ++s) {
    const auto own = placement.known_of(s);
    bool is_explained = own.has_value();
    if (own) has_partner[*own] = true;
    for (const std::size_t k : problem.choices[s]) {
      if (own || !placement.extension({k, s}, density, gates)) continue;
      is_explained = has_partner[k] = true;
    }
    if (!is_explained) alone[1].push_back(problem.sightings[s]);
  }
  for (std::size_t k = 0; k < problem.known.size(); ++k) {
    if (!has_partner[k]) alone[0].push_back(problem.known[k]);
  }
  return alone;
}

}  // namespace

template <int Dim>
double log_overlooked(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                      const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) {
  if (!problem.map_sees || placement.pairings().empty()) return 0.0;
  const auto alone = without_partner(problem, placement, density, gates);
  const auto overlooked = [&](const Point<Dim>& point, const MapFeatures<Dim>& by) {
    return problem.map_sees->log_overlooked(distance_of_nearest<Dim>(point, by.all), 0.0);
  };
  const auto known = [&](const Pairing& pairing) -> const Point<Dim>& { return problem.known[pairing.known]; };
  const auto sighting = [&](const Pairing& pairing) -> const Point<Dim>& { return problem.sightings[pairing.sighting]; };
  double sum = 0.0;
  for (const auto& p : alone[0]) sum += overlooked(p - nearest_difference<Dim>(p, problem, placement, known), problem.maps[1]);
  for (const auto& p : alone[1])
    sum += overlooked(p + nearest_difference<Dim>(p, problem, placement, sighting), problem.maps[0]);
  return sum;
}

template <int Dim>
SightingChance chance_of_maps(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                              const std::vector<std::vector<FeatureIndex>>& unclear) {
  const Table<FeatureIndex, Point<Dim>>& positions = estimate.covariances->state().features;
  const auto distance = [&](FeatureIndex feature, std::size_t map) {
    double least = std::numeric_limits<double>::infinity();
    for (const FeatureIndex other : identities.features_in(map)) {
      if (other != feature) least = std::min(least, (positions[other] - positions[feature]).norm());
    }
    return least;
  };
  std::vector<SightingTrial> trials;
  double reach = 0.0;  // the farthest of a sighting
  const auto add = [&](std::size_t of, std::size_t by, const std::vector<FeatureIndex>& but) {
    for (const FeatureIndex f : identities.features_in(of)) {
      const bool is_seen = std::ranges::binary_search(identities.features_in(by), f);
      if (!is_seen && std::ranges::binary_search(but, f)) continue;
      const double away = distance(f, by);
      if (!std::isfinite(away)) continue;  // the map sees nothing else
      trials.emplace_back(away, is_seen);
      if (is_seen) reach = std::max(reach, away);
    }
  };
  for (std::size_t later = 1; later < estimate.is_local_map.size(); ++later) {
    if (!estimate.is_local_map[later - 1] || !estimate.is_local_map[later]) continue;
    if (identities.features_in(later - 1).empty() || identities.features_in(later).empty()) continue;
    const auto part = [&](std::size_t map) { return estimate.parts.of_feature[identities.features_in(map).front()]; };
    if (part(later - 1) != part(later)) continue;
    add(later - 1, later, unclear[later]);
    add(later, later - 1, unclear[later]);
  }
  std::erase_if(trials, [reach](const auto& trial) { return trial.first > reach; });
  return SightingChance(std::move(trials));
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                   \
  template double log_overlooked(const PairingProblem<Dim>&, const Hypothesis<Dim>&, const NeighbourDensity<Dim>&, \
                                 ChiSquaredQuantiles&);                                                            \
  template SightingChance chance_of_maps(const FeatureEstimate<Dim>&, const Identities&,                           \
                                         const std::vector<std::vector<FeatureIndex>>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
