// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <utility>

namespace mapjoin {
namespace {

FeatureIds names(const Identities& identities) {
  FeatureIds names;
  for (std::size_t k = 0; k < identities.feature_count(); ++k) names.push_back(FeatureId{k + 1});
  return names;
}

/// The join of the submap graph of `data`, with covariances.
template <int Dim, typename Data>
Expected<FeatureEstimate<Dim>> joined(PartNumbers parts, std::shared_ptr<const Data> data, const SubmapGraph<Dim>& graph,
                                      const std::stop_token& stop) {
  FeatureEstimate<Dim> estimate;
  estimate.parts = std::move(parts);
  auto join = mapjoin::join(graph, data->poses, data->features, JoinOptions<Dim>{}, stop);
  if (!join) return tl::unexpected(join.error());
  estimate.restored = std::make_unique<Restored<Dim>>(restored(graph, {}, *join, join->state));
  auto covariances = MapCovariances<Dim>::make(*estimate.restored, Estimate::kJoined);
  if (!covariances) return tl::unexpected(covariances.error());
  estimate.covariances = std::make_unique<const MapCovariances<Dim>>(*std::move(covariances));
  auto marginals = estimate.covariances->on_pattern(nullptr, stop);
  if (!marginals) return tl::unexpected(marginals.error());
  estimate.marginals = std::make_unique<const Marginals>(*std::move(marginals));
  estimate.data = std::move(data);
  return estimate;
}

}  // namespace

template <typename Data>
PartNumbers part_numbers_of(const Data& data) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const TieVertices of = vertices_of(data);
  const std::vector<std::uint32_t> component = components_of(make_graph(of.size(), ties_of(data)));
  std::vector<std::uint32_t> number(component.size(), kNone);  // by component
  PartNumbers parts;
  for (const PoseIndex p : indices(data.poses)) {
    std::uint32_t& part = number[component[of.pose(p)]];
    if (part == kNone) {
      part = static_cast<std::uint32_t>(parts.first_poses.size());
      parts.first_poses.push_back(p);
    }
    parts.of_pose.push_back(part);
  }
  for (const FeatureIndex f : indices(data.features)) parts.of_feature.push_back(number[component[of.feature(f)]]);
  const std::uint32_t world = number[component[TieVertices::kWorldVertex]];
  if (world != kNone) parts.in_world = world;
  return parts;
}

template <typename Data>
PartNumbers hold_parts(Data& data) {
  PartNumbers parts = part_numbers_of(data);
  if (parts.first_poses.size() == 1) return parts;
  for (std::uint32_t k = 0; k < parts.first_poses.size(); ++k) {
    if (k != parts.in_world) data.graph.fixed.push_back({parts.first_poses[k], {}});
  }
  std::ranges::sort(data.graph.fixed, {}, [](const auto& fixed) { return fixed.pose; });
  return parts;
}

template <int Dim>
std::vector<Sighting> sightings_of(const SubmapSet<Dim>& set) {
  std::vector<Sighting> sightings;
  std::size_t scan = 0;
  for (const auto& map : set.graph.submaps) {
    sightings.insert(sightings.end(), map.features.size(), {scan, scan});
    ++scan;
  }
  PoseIndex pose = kWorld;
  for (const auto& observation : set.graph.feature_factors) {
    if (std::exchange(pose, observation.base) != observation.base) ++scan;
    sightings.push_back({scan, scan});
  }
  return sightings;
}

template <int Dim>
std::vector<Sighting> sightings_of(const Log<Dim>& log, const Split& split) {
  std::vector<Sighting> sightings;
  for (std::size_t k = 0; k < split.segments.size(); ++k) {
    for (const auto& o : observations_of(log, split.segments[k])) sightings.push_back({k, o.base.position()});
  }
  return sightings;
}

template <int Dim>
std::vector<NamedSighting> named_sightings(const SubmapSet<Dim>& set) {
  std::vector<NamedSighting> seen;
  for (const auto& map : set.graph.submaps) {
    for (const FeatureIndex feature : map.features) seen.push_back({map.base, feature});
  }
  for (const auto& observation : set.graph.feature_factors) seen.push_back({observation.base, observation.target});
  return seen;
}

template <int Dim>
std::vector<NamedSighting> named_sightings(const Log<Dim>& log) {
  std::vector<NamedSighting> seen;
  for (const auto& observation : log.observations()) seen.push_back({observation.base, observation.target});
  return seen;
}

template <int Dim>
SubmapSet<Dim> renamed(SubmapSet<Dim> set, const Identities& identities) {
  std::size_t sighting = 0;
  for (auto& map : set.graph.submaps) {
    for (FeatureIndex& feature : map.features) feature = identities.feature_of(sighting++);
  }
  for (auto& observation : set.graph.feature_factors) observation.target = identities.feature_of(sighting++);
  set.features = names(identities);
  return set;
}

template <int Dim>
Log<Dim> renamed(Log<Dim> log, const Identities& identities) {
  auto& factors = log.graph.feature_factors;
  factors.erase(factors.begin() + std::ssize(log.observations()), factors.end());  // priors go by names
  for (std::size_t k = 0; k < identities.sighting_count(); ++k) {
    log.graph.feature_factors[k].target = identities.feature_of(k);
  }
  log.features = names(identities);
  log.initial.features.clear();
  return log;
}

template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(SubmapSet<Dim> set, const std::stop_token& stop) {
  PartNumbers parts = hold_parts(set);
  auto data = std::make_shared<const SubmapSet<Dim>>(std::move(set));
  auto estimate = joined(std::move(parts), data, submap_graph_of(*data), stop);
  if (!estimate) return estimate;
  const auto sightings = sightings_of(*data);
  estimate->is_local_map.assign(sightings.empty() ? 0 : sightings.back().map + 1, false);
  std::fill_n(estimate->is_local_map.begin(), std::min(data->graph.submaps.size(), estimate->is_local_map.size()), true);
  return estimate;
}

template <int Dim>
Expected<FeatureEstimate<Dim>> estimate_of(Log<Dim> log, Split split, const std::stop_token& stop) {
  PartNumbers parts = hold_parts(log);
  auto data = std::make_shared<const Log<Dim>>(std::move(log));
  auto built = build_local_maps(*data, split, {}, stop);
  if (!built) return tl::unexpected(built.error());
  auto estimate = joined(std::move(parts), data, submap_graph_of(*data, split, std::move(built->maps)), stop);
  if (!estimate) return estimate;
  for (const Segment& segment : split.segments) estimate->is_local_map.push_back(segment.is_map);
  return estimate;
}

template <int Dim>
std::vector<Variable> FeatureEstimate<Dim>::variables_of(const std::vector<FeatureIndex>& features) const {
  std::vector<Variable> variables;
  for (const FeatureIndex f : features) variables.push_back(covariances->variable(f));
  return variables;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                               \
  template struct FeatureEstimate<Dim>;                                                        \
  template PartNumbers part_numbers_of(const SubmapSet<Dim>&);                                 \
  template PartNumbers part_numbers_of(const Log<Dim>&);                                       \
  template PartNumbers hold_parts(SubmapSet<Dim>&);                                            \
  template PartNumbers hold_parts(Log<Dim>&);                                                  \
  template std::vector<Sighting> sightings_of(const SubmapSet<Dim>&);                          \
  template std::vector<Sighting> sightings_of(const Log<Dim>&, const Split&);                  \
  template std::vector<NamedSighting> named_sightings(const SubmapSet<Dim>&);                  \
  template std::vector<NamedSighting> named_sightings(const Log<Dim>&);                        \
  template SubmapSet<Dim> renamed(SubmapSet<Dim>, const Identities&);                          \
  template Log<Dim> renamed(Log<Dim>, const Identities&);                                      \
  template Expected<FeatureEstimate<Dim>> estimate_of(SubmapSet<Dim>, const std::stop_token&); \
  template Expected<FeatureEstimate<Dim>> estimate_of(Log<Dim>, Split, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
