// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/joined_map.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>& graph) {
  PartialMap<Dim> joined_map;
  for (const PoseIndex p : indices(graph.is_joined)) {
    if (graph.is_joined[p]) joined_map.poses.push_back(p);
  }
  joined_map.factors = graph.factors;
  for (const auto& marginalised : graph.maps) joined_map.factors.submaps.push_back(&marginalised.map);

  Table<FeatureIndex, bool> is_seen(graph.feature_count, false);
  for (const auto* map : joined_map.factors.submaps) {
    for (const FeatureIndex feature : map->features) is_seen[feature] = true;
  }
  for (const auto* selection : {&graph.factors, &graph.priors}) {
    for (const auto* o : selection->feature_factors) is_seen[o->target] = true;
  }
  for (const FeatureIndex f : indices(is_seen)) {
    if (is_seen[f]) joined_map.features.push_back(f);
  }
  joined_map.state.poses.resize(joined_map.poses.size());
  joined_map.state.features.resize(joined_map.features.size(), Point<Dim>::Zero());
  return joined_map;
}

template <int Dim>
Values<Dim> composed_state(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Pose<Dim>& origin,
                           JoinedPartialMaps<Dim> joined) {
  Values<Dim> state = joined_map.state;
  // Poses and features that partial maps share have their values in the first one.
  for (auto partial = joined.partials.rbegin(); partial != joined.partials.rend(); ++partial) {
    place_in_world(graph, origin, *partial);
    for (const PoseIndex p : indices(partial->poses)) {
      state.poses[place_of(joined_map.poses, partial->poses[p])] = partial->state.poses[p];
    }
    for (const FeatureIndex f : indices(partial->features)) {
      state.features[place_of(joined_map.features, partial->features[f])] = partial->state.features[f];
    }
  }
  return state;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                         \
  template PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>&);                                       \
  template Values<Dim> composed_state(const SubmapGraph<Dim>&, const PartialMap<Dim>&, const Pose<Dim>&, \
                                      JoinedPartialMaps<Dim>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
