// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An update while a robot drives: one segment of its way, and the other observations made meanwhile.

#include <algorithm>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// A submap set of one segment, or of none if only single factors came. Its indices count the poses and features that it names
/// itself, whatever other updates name.
/// - `poses`: those of the segment in the order in which they were driven (for a local map its base and the poses it keeps),
///   and others that factors concern, which are of other updates' segments. Names that nothing concerns do not count.
/// - `graph.submaps`: the local map, if the segment is one.
/// - `graph.pose_factors`, `graph.feature_factors`, `graph.fixed`: odometry and observations of a raw segment, closures to
///   known poses, observations from known poses that come late, priors and fixed poses.
template <int Dim>
using SubmapUpdate = SubmapSet<Dim>;

/// The index of a pose or feature among the names of an update, to which a new name is added. O(n).
template <typename Index, typename Id>
Index enter_name(Table<Index, Id>& names, const Id& id) {
  const auto place = std::find(names.begin(), names.end(), id);
  const Index index(place - names.begin());
  if (place == names.end()) names.push_back(id);
  return index;
}

/// The segment of an update; one without poses if it has none.
template <int Dim>
Segment driven_segment(const SubmapUpdate<Dim>& update) {
  return update.segments.empty() ? Segment{0, -1} : update.segments.front();
}

/// The first, or the last, pose of an update's segment, which must be there.
template <int Dim>
const PoseId& first_pose(const SubmapUpdate<Dim>& update) {
  return update.poses[update.segments.front().begin];
}
template <int Dim>
const PoseId& last_pose(const SubmapUpdate<Dim>& update) {
  return update.poses[update.segments.front().end];
}

/// The updates of a whole log, one per segment, as they would have come: closures, pose priors and fixed poses with the segment
/// of their later pose, priors of features with the first segment that sees the feature. `maps` are as build_local_maps made
/// them. Throws std::invalid_argument if check_maps_of_split() finds a fault, or if a factor is of a pose behind the last
/// segment.
template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>& log, const Split& split,
                                                 const std::vector<LocalMap<Dim>>& maps);

/// The updates of a set of local maps, one per segment, distributed as those of a log. Throws std::invalid_argument if
/// check_content() or check_segments() finds a fault.
template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const SubmapSet<Dim>& set);

/// Bad input unless the update is as SubmapUpdate says, with valid numbers, and without levers and losses.
template <int Dim>
Expected<void> check_update(const SubmapUpdate<Dim>& update);

/// The poses and features of an update's segment in the frame of its first pose, from its own observations alone. Its lists of
/// maps and observations stay empty.
template <int Dim>
PartialMap<Dim> composed(const SubmapUpdate<Dim>& update);

/// True if the update has priors or fixed poses.
template <int Dim>
bool speaks_of_world(const SubmapUpdate<Dim>& update);

/// True for an update of closures alone, on which neither another update nor the frame of the map builds.
template <int Dim>
bool has_closures_only(const SubmapUpdate<Dim>& update);

/// An update with the local map of another one, which has nothing else, instead of its own.
template <int Dim>
SubmapUpdate<Dim> with_map(SubmapUpdate<Dim> update, const SubmapUpdate<Dim>& map);

/// The updates as one set, in which a segment that begins with the last pose of another follows it.
template <int Dim>
SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>& updates);

}  // namespace mapjoin
