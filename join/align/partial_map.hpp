// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A partial map of the submap graph: its poses, features and observations, tied together, and their state in a frame of its
// own.

#include <algorithm>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
struct PartialMap {
  Table<PoseIndex, PoseIndex> poses;           ///< Indices in the submap graph, ascending, by place.
  Table<FeatureIndex, FeatureIndex> features;  ///< Indices in the submap graph, ascending, by place.
  Values<Dim> state;                           ///< Values by place, in the map's own frame.
  FactorSelection<Dim> factors;
};

/// The place of an index in a strictly ascending list, or the place where it would be inserted. Takes constant time if the
/// entries before it are consecutive.
template <typename Index>
Index place_of(const Table<Index, Index>& ascending, Index index) {
  if (ascending.empty() || index <= ascending.front()) return 0;
  if (index > ascending.back()) return Index(ascending.size());
  // The last place that the index can have, without gaps before it.
  const Index latest = std::min(Index(index - ascending.front()), Index(ascending.size() - 1));
  if (ascending[latest] == index) return latest;
  return Index(std::lower_bound(ascending.begin(), ascending.begin() + latest.value, index) - ascending.begin());
}

/// The value at the place of an index in an ascending list; null if the list does not hold the index.
template <typename Index, typename T>
const T* find_value(const Table<Index, Index>& ascending, const Table<Index, T>& values, Index index) {
  const Index place = place_of(ascending, index);
  return place.position() < ascending.size() && ascending[place] == index ? &values[place] : nullptr;
}

template <typename Index>
bool holds(const Table<Index, Index>& ascending, Index index) {
  return find_value(ascending, ascending, index) != nullptr;
}

/// The place of a pose or feature in a part that lists them ascending; index_in() is the inverse.
template <typename Part>
PoseIndex place_in(const Part& part, PoseIndex pose) {
  return place_of(part.poses, pose);
}
template <typename Part>
FeatureIndex place_in(const Part& part, FeatureIndex feature) {
  return place_of(part.features, feature);
}
template <typename Part>
PoseIndex index_in(const Part& part, PoseIndex place) {
  return part.poses[place];
}
template <typename Part>
FeatureIndex index_in(const Part& part, FeatureIndex place) {
  return part.features[place];
}

template <int Dim>
const Pose<Dim>& pose_in(const PartialMap<Dim>& partial, PoseIndex pose) {
  return partial.state.poses[place_of(partial.poses, pose)];
}

template <int Dim>
const Point<Dim>& feature_in(const PartialMap<Dim>& partial, FeatureIndex feature) {
  return partial.state.features[place_of(partial.features, feature)];
}

template <int Dim>
const Pose<Dim>* find_pose(const PartialMap<Dim>& partial, PoseIndex pose) {
  return find_value(partial.poses, partial.state.poses, pose);
}

template <int Dim>
const Point<Dim>* find_feature(const PartialMap<Dim>& partial, FeatureIndex feature) {
  return find_value(partial.features, partial.state.features, feature);
}

/// chi2 of all observations and maps of a partial map at its state.
template <int Dim>
double partial_map_chi2(const PartialMap<Dim>& partial) {
  const auto& [pose_factors, feature_factors, submaps] = partial.factors;
  double chi2 = 0.0;
  for (const auto* o : pose_factors) chi2 += cost(*o, pose_in(partial, o->base), pose_in(partial, o->target));
  for (const auto* o : feature_factors) chi2 += cost(*o, pose_in(partial, o->base), feature_in(partial, o->target));
  for (const auto* map : submaps) {
    chi2 += cost(
        *map, pose_in(partial, map->base), [&](std::size_t p) { return pose_in(partial, map->poses[p]); },
        [&](std::size_t f) { return feature_in(partial, map->features[f]); });
  }
  return chi2;
}

}  // namespace mapjoin
