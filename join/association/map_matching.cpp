// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/map_matching.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/cross_covariances.hpp>

namespace mapjoin {

template <int Dim>
MapMatching<Dim>::MapMatching(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                              const NeighbourDensity<Dim>& density, AssociationMethod method, double confidence,
                              double decisions)
    : estimate_(estimate),
      identities_(identities),
      density_(density),
      method_(method),
      confidence_(confidence),
      decisions_(decisions),
      candidates_(estimate, identities, density, matcher().gate()) {
  // Nearest neighbours go by distances alone.
  if (method != AssociationMethod::kNearest) map_sees_ = candidates_.sighting_chance();
}

template <int Dim>
Matcher<Dim> MapMatching<Dim>::matcher() const {
  return {density_, method_, confidence_, decisions_};
}

template <int Dim>
double MapMatching<Dim>::placement_confidence() const {
  return 1.0 - (1.0 - confidence_) / static_cast<double>(identities_.map_count());
}

template <int Dim>
double MapMatching<Dim>::log_pairs() const {
  const auto maps = static_cast<double>(identities_.map_count());
  return std::log(0.5 * maps * (maps - 1.0));
}

/// The features of a map; unpaired are those that the other map does not see and that are not candidates.
template <int Dim>
MatchedMap<Dim> MapMatching<Dim>::features_of(std::size_t map, std::size_t other,
                                              const std::set<FeatureIndex>& candidates) const {
  MatchedMap<Dim> features;
  for (const FeatureIndex f : identities_.features_in(map)) {
    features.all.push_back(estimate_.position(f));
    if (!candidates.contains(f) && !identities_.sees(other, f)) features.unpaired.push_back(estimate_.position(f));
  }
  return features;
}

/// The joint covariance of features that one map sees.
template <int Dim>
Eigen::MatrixXd MapMatching<Dim>::joint(const std::vector<FeatureIndex>& features, std::size_t map) const {
  const std::vector<Variable> variables = estimate_.variables_of(features);
  if (estimate_.is_local_map[map]) return estimate_.scale * estimate_.marginals->joint(variables);
  return estimate_.scale * CrossCovariances(estimate_.covariances->equations()).joint(variables);
}

template <int Dim>
PairingProblem<Dim> MapMatching<Dim>::problem(const std::vector<FeatureIndex>& known,
                                              const std::vector<std::size_t>& open_places, const OpenFeatures<Dim>& open,
                                              std::size_t known_map) const {
  PairingProblem<Dim> problem;
  for (const FeatureIndex f : known) problem.known.push_back(estimate_.position(f));
  const Eigen::Index first = problem.row_of_sighting(0);
  const Eigen::Index rows = problem.row_of_sighting(open_places.size());
  problem.covariance.resize(rows, rows);
  problem.covariance.topLeftCorner(first, first) = joint(known, known_map);
  for (std::size_t s = 0; s < open_places.size(); ++s) {
    const std::size_t place = open_places[s];
    problem.sightings.push_back(estimate_.position(open.features[place]));
    const Eigen::Index column = problem.row_of_sighting(s);
    for (std::size_t k = 0; k < known.size(); ++k) {
      problem.covariance.template block<Dim, Dim>(problem.row_of_known(k), column) = open.covariance(known[k], place);
    }
    for (std::size_t k = 0; k < open_places.size(); ++k) {
      problem.covariance.template block<Dim, Dim>(problem.row_of_sighting(k), column) =
          open.covariance(open.features[open_places[k]], place);
    }
    auto& choices = problem.choices.emplace_back();
    for (std::size_t k = 0; k < known.size(); ++k) {
      if (std::ranges::find(open.candidates[place], known[k], &Candidate<Dim>::feature) != open.candidates[place].end()) {
        choices.push_back(k);
      }
    }
  }
  problem.covariance.bottomLeftCorner(rows - first, first) = problem.covariance.topRightCorner(first, rows - first).transpose();
  return problem;
}

template <int Dim>
Proposals MapMatching<Dim>::of_pair(std::size_t earlier, std::size_t later, const OpenFeatures<Dim>& open, double reach,
                                    Matcher<Dim>& matcher) const {
  std::set<FeatureIndex> known, sightings;
  std::vector<std::size_t> places;
  double confusable = 0.0;
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    if (identities_.sees(earlier, open.features[k])) continue;
    bool has_candidate = false;
    for (const Candidate<Dim>& candidate : open.candidates[k]) {
      if (!identities_.sees(earlier, candidate.feature) || identities_.sees(later, candidate.feature)) continue;
      has_candidate = true;
      known.insert(candidate.feature);
      confusable = std::max(confusable, candidate.confusable);
    }
    if (!has_candidate) continue;
    places.push_back(k);
    sightings.insert(open.features[k]);
  }
  if (places.empty()) return {};
  if (confusable > reach) return {{}, 1};
  const std::vector<FeatureIndex> features(known.begin(), known.end());
  PairingProblem<Dim> pairing = problem(features, places, open, earlier);
  pairing.maps = {features_of(earlier, later, known), features_of(later, earlier, sightings)};
  pairing.map_sees = &map_sees_;
  if (confusable > 1.0) pairing.log_tests = log_pairs();
  const std::vector<Match> matches = matcher(std::move(pairing));
  Proposals proposals;
  for (std::size_t s = 0; s < places.size(); ++s) {
    if (!matches[s].known || matches[s].probability < confidence_) continue;
    if (matches[s].placement_probability < placement_confidence()) continue;
    const FeatureIndex feature = open.features[places[s]];
    proposals.probable.push_back({features[*matches[s].known], feature, matches[s], {earlier, later}});
  }
  return proposals;
}

/// Matches the set-aside sightings of a map, scan by scan, with features of it that were seen more often or before.
template <int Dim>
Proposals MapMatching<Dim>::within(std::size_t map, const OpenFeatures<Dim>& open, Matcher<Dim>& matcher) const {
  std::map<std::size_t, std::vector<std::size_t>> scans;
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    const auto sightings = identities_.sightings_of(open.features[k]);
    if (sightings.size() == 1) scans[identities_.sighting(sightings.front()).scan].push_back(k);
  }
  Proposals proposals;
  for (const auto& [scan, set_aside] : scans) {
    std::set<FeatureIndex> known;
    std::vector<std::size_t> places;
    for (const std::size_t k : set_aside) {
      const std::size_t before = known.size();
      for (const Candidate<Dim>& candidate : open.candidates[k]) {
        const bool is_known = identities_.sightings_of(candidate.feature).size() > 1 || candidate.feature < open.features[k];
        if (is_known && identities_.sees(map, candidate.feature)) known.insert(candidate.feature);
      }
      if (known.size() > before) places.push_back(k);
    }
    if (places.empty()) continue;
    const std::vector<FeatureIndex> features(known.begin(), known.end());
    const std::vector<Match> matches = matcher(problem(features, places, open, map));
    for (std::size_t s = 0; s < places.size(); ++s) {
      if (!matches[s].known || matches[s].probability < confidence_) continue;
      proposals.probable.push_back({features[*matches[s].known], open.features[places[s]], matches[s], {map, map}});
    }
  }
  return proposals;
}

template <int Dim>
Proposals MapMatching<Dim>::of_map(std::size_t map, double reach, bool only_neighbours, const std::stop_token& stop) const {
  if (stop.stop_requested()) return {};
  const OpenFeatures<Dim> open = candidates_.of_map(map, only_neighbours);
  std::set<std::size_t> earlier;
  for (const auto& candidates : open.candidates) {
    for (const Candidate<Dim>& candidate : candidates) {
      for (const std::size_t s : identities_.sightings_of(candidate.feature)) earlier.insert(identities_.sighting(s).map);
    }
  }
  Matcher<Dim> matcher = this->matcher();
  Proposals proposals = within(map, open, matcher);
  for (const std::size_t other : earlier) {
    if (stop.stop_requested()) return {};
    if (other >= map || (only_neighbours && other + 1 < map)) continue;
    const Proposals more = of_pair(other, map, open, reach, matcher);
    proposals.probable.insert(proposals.probable.end(), more.probable.begin(), more.probable.end());
    proposals.beyond_reach += more.beyond_reach;
  }
  return proposals;
}

template <int Dim>
Proposals MapMatching<Dim>::propose(double reach, bool only_neighbours, const std::stop_token& stop) const {
  std::vector<Proposals> of_maps(identities_.map_count());
  parallel_for(of_maps.size(), [&](std::size_t map) { of_maps[map] = of_map(map, reach, only_neighbours, stop); });
  Proposals all;
  for (const Proposals& some : of_maps) {
    all.probable.insert(all.probable.end(), some.probable.begin(), some.probable.end());
    all.beyond_reach += some.beyond_reach;
  }
  return all;
}

template <int Dim>
std::vector<MapPair<Dim>> MapMatching<Dim>::pairs_of(std::size_t map, double reach) const {
  const OpenFeatures<Dim> open = candidates_.of_map(map, false);
  std::map<std::size_t, MapPair<Dim>> of_earlier;
  for (std::size_t k = 0; k < open.features.size(); ++k) {
    for (const Candidate<Dim>& candidate : open.candidates[k]) {
      if (candidate.confusable > reach) continue;
      for (const std::size_t s : identities_.sightings_of(candidate.feature)) {
        const std::size_t earlier = identities_.sighting(s).map;
        if (earlier >= map || identities_.sees(earlier, open.features[k]) || identities_.sees(map, candidate.feature)) continue;
        const MapPair<Dim> found{
            {earlier, map}, {candidate.feature, open.features[k]}, candidate.confusable, candidate.covariance};
        const auto [least, is_first] = of_earlier.try_emplace(earlier, found);
        if (!is_first && found.confusable < least->second.confusable) least->second = found;
      }
    }
  }
  std::vector<MapPair<Dim>> pairs;
  for (const auto& [earlier, pair] : of_earlier) pairs.push_back(pair);
  return pairs;
}

template <int Dim>
std::vector<MapPair<Dim>> MapMatching<Dim>::pairs(double reach, const std::stop_token& stop) const {
  std::vector<std::vector<MapPair<Dim>>> of_maps(identities_.map_count());
  parallel_for(of_maps.size(), [&](std::size_t map) {
    if (!stop.stop_requested()) of_maps[map] = pairs_of(map, reach);
  });
  std::vector<MapPair<Dim>> all;
  for (const auto& some : of_maps) all.insert(all.end(), some.begin(), some.end());
  return all;
}

template class MapMatching<2>;
template class MapMatching<3>;

}  // namespace mapjoin
