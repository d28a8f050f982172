// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/frames/name_fit.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// The most features of one name by which two parts are compared; more would not change the share.
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

/// The base and the name, a feature of the data, of each sighting.
using Seen = std::vector<std::pair<PoseIndex, FeatureIndex>>;

/// Parts of the data, by their first poses, with the features that each names.
struct NamedParts {
  std::vector<PoseId> first_poses;
  std::vector<NamedFeatures> named;
};

/// The worst fit of names in the maps of parts.
template <int Dim>
Expected<std::optional<NameFit>> worst_fit_in(const FeatureEstimate<Dim>& maps, const NamedParts& parts, double gate) {
  std::optional<NameFit> worst;
  for (std::size_t b = 1; b < parts.named.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto both = shared(parts.named[a], parts.named[b]);
      if (both.size() < 2) continue;
      std::vector<FeatureIndex> of_a, of_b;
      const std::size_t step = (both.size() + kMostShared - 1) / kMostShared;
      for (std::size_t k = 0; k < both.size(); k += step) {
        of_a.push_back(both[k].first);
        of_b.push_back(both[k].second);
      }
      const auto first = feature_map_of(maps, of_a);
      const auto second = feature_map_of(maps, of_b);
      if (!first || !second) return tl::unexpected(first ? second.error() : first.error());
      const NameFit fit{parts.first_poses[a], parts.first_poses[b], both.size(), share_alike(*first, *second, gate)};
      if (!worst || fit.alike < worst->alike) worst = fit;
    }
  }
  return worst;
}

/// The worst fit of names; `join` makes the joined map of data in which no two parts share a feature.
template <int Dim, typename Data, typename Join>
Expected<std::optional<NameFit>> worst_fit(const Data& data, const Seen& seen, std::vector<Sighting> sightings,
                                           double confidence, const std::stop_token& stop, const Join& join) {
  std::vector<std::size_t> labels(seen.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  const PartNumbers numbers = part_numbers_of(renamed(data, Identities(sightings, labels)));
  for (std::size_t s = 0; s < seen.size(); ++s) {
    labels[s] = numbers.of_pose[seen[s].first] * data.features.size() + seen[s].second.position();
  }
  const Identities identities(std::move(sightings), labels);
  NamedParts parts{{}, std::vector<NamedFeatures>(numbers.first_poses.size())};
  for (const PoseIndex pose : numbers.first_poses) parts.first_poses.push_back(data.poses[pose]);
  for (std::size_t s = 0; s < seen.size(); ++s) {
    parts.named[numbers.of_pose[seen[s].first]].emplace(seen[s].second, identities.feature_of(s));
  }
  Data apart = renamed(data, identities);
  const double gate = chi_squared_quantile(confidence, 1);
  const auto fit_of = [&](const Data& some) {
    return join(some).and_then([&](const FeatureEstimate<Dim>& maps) { return worst_fit_in(maps, parts, gate); });
  };
  auto worst = fit_of(apart);
  if (!worst || !*worst || (*worst)->is_good()) return worst;
  hold_parts(apart);
  const auto inliers = find_inliers(apart, {.confidence = confidence}, stop);
  if (inliers) return inliers->rejected.empty() ? worst : fit_of(inliers->input);
  if (inliers.error().kind == ErrorKind::kInterrupted) return tl::unexpected(inliers.error());
  return worst;
}

}  // namespace

template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>& log, double confidence, const std::stop_token& stop) {
  Seen seen;
  for (const auto& observation : log.observations()) seen.emplace_back(observation.base, observation.target);
  const auto cut = [](const Log<Dim>& some) { return split(some, SplitOptions{}); };
  return worst_fit<Dim>(log, seen, sightings_of(log, cut(log)), confidence, stop,
                        [&](const Log<Dim>& some) { return estimate_of(some, cut(some), stop); });
}

template <int Dim>
Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim> set, double confidence, const std::stop_token& stop) {
  std::erase_if(set.graph.feature_factors, [](const auto& o) { return o.base == kWorld; });  // priors go by names
  Seen seen;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) seen.emplace_back(map.base, feature);
  }
  for (const auto& observation : set.graph.feature_factors) seen.emplace_back(observation.base, observation.target);
  return worst_fit<Dim>(set, seen, sightings_of(set), confidence, stop,
                        [&](const SubmapSet<Dim>& some) { return estimate_of(some, stop); });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template Expected<std::optional<NameFit>> worst_name_fit(const Log<Dim>&, double, const std::stop_token&); \
  template Expected<std::optional<NameFit>> worst_name_fit(SubmapSet<Dim>, double, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
