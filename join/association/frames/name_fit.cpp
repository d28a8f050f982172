// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/frames/name_fit.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Features of one name that two parts are compared by; more would not change the share.
constexpr std::size_t kMostShared = 60;

/// The feature of each name in a part.
using NamedFeatures = std::map<FeatureIndex, FeatureIndex>;

/// The features of the same names in two parts.
std::vector<std::pair<FeatureIndex, FeatureIndex>> shared(const NamedFeatures& first, const NamedFeatures& second) {
  std::vector<std::pair<FeatureIndex, FeatureIndex>> both;
  for (const auto& [name, feature] : first) {
    if (const auto other = second.find(name); other != second.end()) both.emplace_back(feature, other->second);
  }
  return both;
}

/// The share of distances that are the same in two maps of the same features.
template <int Dim>
double share_alike(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, double gate) {
  double alike = 0.0;
  double all = 0.0;
  for (std::size_t i = 0; i < first.features.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k, ++all) {
      const double difference =
          (first.features[i] - first.features[k]).norm() - (second.features[i] - second.features[k]).norm();
      const double variance = first.variance_of_distance(i, k) + second.variance_of_distance(i, k);
      if (difference * difference <= gate * variance) ++alike;
    }
  }
  return alike / all;
}

/// The name of each sighting, by its base and its feature in the data.
using Seen = std::vector<std::pair<PoseIndex, FeatureIndex>>;

/// `join` makes the joined map of the data with other names.
template <int Dim, typename Data, typename Join>
Expected<std::optional<NameFit>> worst_fit(const Data& data, const Seen& seen, std::vector<Sighting> sightings,
                                           double confidence, const Join& join) {
  std::vector<std::size_t> labels(seen.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  const PartNumbers parts = part_numbers_of(renamed(data, Identities(sightings, labels)));
  for (std::size_t s = 0; s < seen.size(); ++s) {
    labels[s] = parts.of_pose[seen[s].first] * data.features.size() + seen[s].second.position();
  }
  const Identities apart(std::move(sightings), labels);
  std::vector<NamedFeatures> named(parts.first_poses.size());
  for (std::size_t s = 0; s < seen.size(); ++s) {
    named[parts.of_pose[seen[s].first]].emplace(seen[s].second, apart.feature_of(s));
  }
  const auto estimate = join(renamed(data, apart));
  if (!estimate) return tl::unexpected(estimate.error());
  std::optional<NameFit> worst;
  const double gate = chi_squared_quantile(confidence, 1);
  for (std::size_t b = 1; b < named.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto both = shared(named[a], named[b]);
      if (both.size() < 2) continue;
      std::vector<FeatureIndex> of_a, of_b;
      const std::size_t step = (both.size() + kMostShared - 1) / kMostShared;
      for (std::size_t k = 0; k < both.size(); k += step) {
        of_a.push_back(both[k].first);
        of_b.push_back(both[k].second);
      }
      const auto first = feature_map_of(*estimate, of_a);
      const auto second = feature_map_of(*estimate, of_b);
      if (!first || !second) return tl::unexpected(first ? second.error() : first.error());
      const NameFit fit{data.poses[parts.first_poses[a]], data.poses[parts.first_poses[b]], both.size(),
                        share_alike(*first, *second, gate)};
      if (!worst || fit.alike < worst->alike) worst = fit;
    }
  }
  return worst;
}

}  // namespace

template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>& log, double confidence, const std::stop_token& stop) {
  const Split parts = split(log, SplitOptions{});
  Seen seen;
  for (const auto& observation : log.observations()) seen.emplace_back(observation.base, observation.target);
  return worst_fit<Dim>(log, seen, sightings_of(log, parts), confidence,
                        [&](Log<Dim> renamed) { return estimate_of(std::move(renamed), parts, stop); });
}

template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim> set, double confidence, const std::stop_token& stop) {
  std::erase_if(set.graph.feature_factors, [](const auto& o) { return o.base == kWorld; });  // they go by names
  Seen seen;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) seen.emplace_back(map.base, feature);
  }
  for (const auto& observation : set.graph.feature_factors) seen.emplace_back(observation.base, observation.target);
  return worst_fit<Dim>(set, seen, sightings_of(set), confidence,
                        [&](SubmapSet<Dim> renamed) { return estimate_of(std::move(renamed), stop); });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>&, double, const std::stop_token&); \
  template Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim>, double, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
