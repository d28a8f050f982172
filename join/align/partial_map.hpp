// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A partial map of the submap graph that hangs together: its poses, features and observations, and their state in a frame of
// its own.

#include <algorithm>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
struct PartialMap {
  std::vector<Index> poses;     ///< Of the submap graph, ascending.
  std::vector<Index> features;  ///< Of the submap graph, ascending.
  Values<Dim> state;            ///< By place in `poses` and `features`.
  FactorSelection<Dim> factors;
};

/// The place of an index in a strictly ascending list, or where it would stand. Constant time where what stands before it is
/// consecutive.
inline Index place_of(const std::vector<Index>& ascending, Index index) {
  if (ascending.empty() || index <= ascending.front()) return 0;
  if (index > ascending.back()) return static_cast<Index>(ascending.size());
  // No later than where it stands if none is missing.
  const auto latest = std::min(static_cast<std::size_t>(index - ascending.front()), ascending.size() - 1);
  if (ascending[latest] == index) return static_cast<Index>(latest);
  return static_cast<Index>(
      std::lower_bound(ascending.begin(), ascending.begin() + static_cast<std::ptrdiff_t>(latest), index) - ascending.begin());
}

/// The value that stands where an index does in an ascending list, or null where the list does not hold it.
template <typename T>
const T* find_value(const std::vector<Index>& ascending, const std::vector<T>& values, Index index) {
  const auto place = static_cast<std::size_t>(place_of(ascending, index));
  return place < ascending.size() && ascending[place] == index ? &values[place] : nullptr;
}

inline bool holds(const std::vector<Index>& ascending, Index index) {
  return find_value(ascending, ascending, index) != nullptr;
}

template <int Dim>
const Pose<Dim>& pose_in(const PartialMap<Dim>& partial, Index pose) {
  return partial.state.poses[static_cast<std::size_t>(place_of(partial.poses, pose))];
}

template <int Dim>
const Point<Dim>& feature_in(const PartialMap<Dim>& partial, Index feature) {
  return partial.state.features[static_cast<std::size_t>(place_of(partial.features, feature))];
}

template <int Dim>
const Pose<Dim>* find_pose(const PartialMap<Dim>& partial, Index pose) {
  return find_value(partial.poses, partial.state.poses, pose);
}

template <int Dim>
const Point<Dim>* find_feature(const PartialMap<Dim>& partial, Index feature) {
  return find_value(partial.features, partial.state.features, feature);
}

}  // namespace mapjoin
