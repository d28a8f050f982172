// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What becomes known at once while a robot drives: one segment of its way, and what else was observed meanwhile.

#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Updates come in the order of their segments, of which successive ones of a session share their end/start pose. Poses and
/// features are named by indices that grow as they become known; poses inside a map that are not kept have one, too.
template <int Dim>
struct SubmapUpdate {
  std::optional<Segment> segment;    ///< None where only single observations came.
  std::optional<LocalMap<Dim>> map;  ///< Of the segment, where that is a map.
  /// Odometry of a raw segment, closures to what is known, and, from the World, priors.
  std::vector<PoseFactor<Dim>> pose_factors;
  std::vector<FeatureFactor<Dim>> feature_factors;  ///< Of a raw segment, and priors.
  std::vector<FixedPose<Dim>> fixed;
};

/// A whole log in updates, one per segment, as it would have become known: closures and what the World says with the segment of
/// their later pose, priors of features with the first segment that sees the feature. `maps` as build_local_maps made them.
template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>& log, const Split& split,
                                                 const std::vector<LocalMap<Dim>>& maps);

/// The poses and features of an update's segment in the frame of its first pose, from its own observations alone. Its lists of
/// maps and observations stay empty.
template <int Dim>
PartialMap<Dim> composed(const SubmapUpdate<Dim>& update);

/// The update's single observations, each as a map of one target.
template <int Dim>
std::vector<LocalMap<Dim>> observations_as_maps(const SubmapUpdate<Dim>& update);

/// Whether the update has priors or fixed poses.
template <int Dim>
bool speaks_of_world(const SubmapUpdate<Dim>& update);

/// Updates as one set of maps; poses and features have their index as their key.
template <int Dim>
SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>& updates);

/// As that of any set of maps, but for poses inside maps, which are not joined. `set` must outlive it.
template <int Dim>
SubmapGraph<Dim> submap_graph_of_updates(const SubmapSet<Dim>& set);

}  // namespace mapjoin
