// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/localmap/segment_view.hpp>

namespace mapjoin {
namespace {

/// The segment at which a pose is known.
std::size_t segment_of(const std::vector<Segment>& segments, Index pose) {
  const auto ends_at_or_after = [](const Segment& segment, Index p) { return segment.end < p; };
  return static_cast<std::size_t>(std::lower_bound(segments.begin(), segments.end(), pose, ends_at_or_after) -
                                  segments.begin());
}

template <int Dim>
std::vector<std::size_t> first_seen(const std::vector<SubmapUpdate<Dim>>& updates, std::size_t features) {
  std::vector<std::size_t> first(features, updates.size() - 1);
  for (std::size_t k = updates.size(); k-- > 0;) {
    if (updates[k].map) {
      for (const Index f : updates[k].map->features) first[static_cast<std::size_t>(f)] = k;
    }
    for (const auto& o : updates[k].feature_factors) first[static_cast<std::size_t>(o.target)] = k;
  }
  return first;
}

}  // namespace

template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>& log, const Split& split,
                                                 const std::vector<LocalMap<Dim>>& maps) {
  std::vector<SubmapUpdate<Dim>> updates;
  auto map = maps.begin();
  for (const Segment& segment : split.segments) {
    SubmapUpdate<Dim>& update = updates.emplace_back();
    update.segment = segment;
    if (segment.is_map) {
      update.map = *map++;
      continue;
    }
    const auto odometry = odometry_of(log, segment);
    const auto observations = observations_of(log, segment);
    update.pose_factors.assign(odometry.begin(), odometry.end());
    update.feature_factors.assign(observations.begin(), observations.end());
  }
  const auto part_of = [&](Index pose) -> SubmapUpdate<Dim>& { return updates[segment_of(split.segments, pose)]; };
  for (const auto& o : log.closures()) part_of(std::max(o.base, o.target)).pose_factors.push_back(o);
  for (const auto& o : log.pose_priors()) part_of(o.target).pose_factors.push_back(o);
  for (const auto& fixed : log.graph.fixed) part_of(fixed.pose).fixed.push_back(fixed);
  const auto seen = first_seen(updates, log.features.size());
  for (const auto& o : log.feature_priors()) updates[seen[static_cast<std::size_t>(o.target)]].feature_factors.push_back(o);
  return updates;
}

template <int Dim>
PartialMap<Dim> composed(const SubmapUpdate<Dim>& update) {
  if (!update.segment) return {};
  const auto is_inside = [&](Index pose) { return pose >= update.segment->begin && pose <= update.segment->end; };
  SubmapGraph<Dim> alone;
  alone.segments = {*update.segment};
  if (update.map) alone.maps.push_back({*update.map, {}, {}, {}, {}});
  for (const auto& o : update.pose_factors) {
    if (is_inside(o.base) && is_inside(o.target)) alone.factors.pose_factors.push_back(&o);
  }
  for (const auto& o : update.feature_factors) {
    if (is_inside(o.base)) alone.factors.feature_factors.push_back(&o);
  }
  PartialMap<Dim> partial = Leaves<Dim>(alone).partial(0);
  partial.factors = {};
  return partial;
}

template <int Dim>
std::vector<LocalMap<Dim>> observations_as_maps(const SubmapUpdate<Dim>& update) {
  std::vector<LocalMap<Dim>> maps;
  for (const auto& o : update.pose_factors) maps.push_back({o.base, {o.target}, {}, {o.measured}, {}, o.information});
  for (const auto& o : update.feature_factors) maps.push_back({o.base, {}, {o.target}, {}, {o.measured}, o.information});
  return maps;
}

template <int Dim>
bool speaks_of_world(const SubmapUpdate<Dim>& update) {
  const auto is_of_world = [](const auto& o) { return o.base == kWorld; };
  return !update.fixed.empty() || std::any_of(update.pose_factors.begin(), update.pose_factors.end(), is_of_world) ||
         std::any_of(update.feature_factors.begin(), update.feature_factors.end(), is_of_world);
}

template <int Dim>
SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>& updates) {
  SubmapSet<Dim> set;
  Index poses = 0;
  Index features = 0;
  for (const SubmapUpdate<Dim>* update : updates) {
    if (update->segment) set.segments.push_back(*update->segment);
    if (update->segment) poses = std::max(poses, update->segment->end + 1);
    if (update->map) set.graph.submaps.push_back(*update->map);
    if (update->map) {
      for (const Index f : update->map->features) features = std::max(features, f + 1);
    }
    for (const auto& o : update->pose_factors) set.graph.pose_factors.push_back(o);
    for (const auto& o : update->feature_factors) {
      set.graph.feature_factors.push_back(o);
      features = std::max(features, o.target + 1);
    }
    for (const auto& fixed : update->fixed) set.graph.fixed.push_back(fixed);
  }
  for (Index p = 0; p < poses; ++p) set.poses.push_back({0, static_cast<std::uint64_t>(p)});
  for (Index f = 0; f < features; ++f) set.features.push_back({static_cast<std::uint64_t>(f)});
  return set;
}

template <int Dim>
SubmapGraph<Dim> submap_graph_of_updates(const SubmapSet<Dim>& set) {
  SubmapGraph<Dim> graph = submap_graph_of(set);
  graph.is_joined.assign(set.poses.size(), false);
  const auto join = [&](Index pose) { graph.is_joined[static_cast<std::size_t>(pose)] = true; };
  for (const auto& marginalised : graph.maps) {
    join(marginalised.map.base);
    std::for_each(marginalised.map.poses.begin(), marginalised.map.poses.end(), join);
  }
  for (const Segment& segment : set.segments) {
    for (Index pose = segment.begin; !segment.is_map && pose <= segment.end; ++pose) join(pose);
  }
  return graph;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&); \
  template PartialMap<Dim> composed(const SubmapUpdate<Dim>&);                                                                 \
  template std::vector<LocalMap<Dim>> observations_as_maps(const SubmapUpdate<Dim>&);                                          \
  template bool speaks_of_world(const SubmapUpdate<Dim>&);                                                                     \
  template SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>&);                                                \
  template SubmapGraph<Dim> submap_graph_of_updates(const SubmapSet<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
