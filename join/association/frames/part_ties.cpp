// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/association/frames/part_ties.hpp>

namespace mapjoin {
namespace {

/// A part: its features, and the map of these.
template <int Dim>
struct Part {
  std::vector<FeatureIndex> features;
  FeatureMap<Dim> map;
};

template <int Dim>
Expected<Part<Dim>> part_of(const FeatureEstimate<Dim>& estimate, std::uint32_t number) {
  const Values<Dim>& state = estimate.covariances->state();
  Part<Dim> part;
  for (const FeatureIndex f : indices(state.features)) {
    if (estimate.parts.of_feature[f] == number) part.features.push_back(f);
  }
  return feature_map_of(estimate, part.features).map([&](FeatureMap<Dim>&& map) {
    part.map = std::move(map);
    for (const PoseIndex p : indices(state.poses)) {
      const bool is_its = estimate.parts.of_pose[p] == number && estimate.restored->graph.is_joined[p];
      if (is_its) part.map.poses.push_back(state.poses[p].translation);
    }
    return std::move(part);
  });
}

/// The chance of a sighting, learnt from the distances at which local maps see, or do not see, features that others know.
template <int Dim>
SightingChance sighting_chance(const FeatureEstimate<Dim>& estimate, const Identities& identities) {
  const Values<Dim>& state = estimate.covariances->state();
  std::vector<SightingTrial> trials;
  double reach = 0.0;
  auto local_map = estimate.restored->graph.maps.begin();
  for (std::size_t m = 0; m < estimate.is_local_map.size(); ++m) {
    if (!estimate.is_local_map[m]) continue;
    const LocalMap<Dim>& map = (local_map++)->map;
    const auto distance = [&](FeatureIndex f) {
      double least = (state.poses[map.base].translation - state.features[f]).norm();
      for (const PoseIndex p : map.poses) least = std::min(least, (state.poses[p].translation - state.features[f]).norm());
      return least;
    };
    const auto seen = identities.features_in(m);
    for (const FeatureIndex f : seen) reach = std::max(reach, distance(f));
    for (const FeatureIndex f : indices(state.features)) {
      if (estimate.parts.of_feature[f] != estimate.parts.of_pose[map.base]) continue;
      const auto sees = [&](std::size_t s) { return identities.sighting(s).map != m; };
      if (!std::ranges::any_of(identities.sightings_of(f), sees)) continue;
      trials.emplace_back(distance(f), std::ranges::binary_search(seen, f));
    }
  }
  std::erase_if(trials, [reach](const auto& trial) { return trial.first > reach; });
  return SightingChance(std::move(trials));
}

}  // namespace

template <int Dim>
Expected<PartTies> ties_between_parts(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                                      const NeighbourDensity<Dim>& density, double confidence, const std::stop_token& stop) {
  std::vector<Part<Dim>> parts;
  for (std::uint32_t k = 0; k < estimate.parts.first_poses.size(); ++k) {
    auto part = part_of(estimate, k);
    if (!part) return tl::unexpected(part.error());
    parts.push_back(*std::move(part));
  }
  const SightingChance sees = sighting_chance(estimate, identities);
  const double pairs = 0.5 * static_cast<double>(parts.size() * (parts.size() - 1));
  const AlignmentModel<Dim> model{density, sees, confidence, std::log(pairs)};
  PartTies found;
  std::vector<PartsApart> aligned;
  for (std::uint32_t b = 1; b < parts.size(); ++b) {
    for (std::uint32_t a = 0; a < b; ++a) {
      if (stop.stop_requested()) return interrupted("associating");
      PartsApart pair{a, b, align_maps(parts[a].map, parts[b].map, model)};
      (pair.alignment.status == AlignmentStatus::kFound ? aligned : found.apart).push_back(std::move(pair));
    }
  }
  std::ranges::stable_sort(aligned, std::greater<>(), [](const PartsApart& pair) { return pair.alignment.score; });
  std::vector<Edge> edges;
  std::vector<Vertex> roots;
  for (const PartsApart& pair : aligned) edges.emplace_back(pair.first, pair.second);
  for (Vertex k = 0; k < parts.size(); ++k) roots.push_back(k);
  for (const Reached& reached : spanning_forest(parts.size(), edges, roots)) {
    if (!reached.edge) continue;
    const PartsApart& pair = aligned[*reached.edge];
    for (const Pairing& p : pair.alignment.pairs) {
      found.ties.emplace_back(parts[pair.first].features[p.known], parts[pair.second].features[p.sighting]);
    }
  }
  return found;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template Expected<PartTies> ties_between_parts(const FeatureEstimate<Dim>&, const Identities&, const NeighbourDensity<Dim>&, \
                                                 double, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
