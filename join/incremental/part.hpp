// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What becomes known at once while a robot drives: one stretch of its way, and what else was observed meanwhile.

#include <mapjoin/join/align/piece.hpp>
#include <mapjoin/join/network.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/map_set.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Parts come in the order of their stretches, of which successive ones of a session share their end/start pose. Poses and
/// features are named by indices that grow as they become known; poses inside a map that are not kept have one, too.
template <int Dim>
struct Part {
  std::optional<Stretch> stretch;    ///< None where only single observations came.
  std::optional<LocalMap<Dim>> map;  ///< Of the stretch, where that is a map.
  /// Odometry of a span, closures to what is known, and, from the World, priors.
  std::vector<PoseObservation<Dim>> pose_observations;
  std::vector<FeatureObservation<Dim>> feature_observations;  ///< Of a span, and priors.
  std::vector<FixedPose<Dim>> fixed;
};

/// A whole log in parts, one per stretch, as it would have become known: closures and what the World says with the stretch of
/// their later pose, priors of features with the first stretch that sees the feature. `maps` as build_local_maps made them.
template <int Dim>
std::vector<Part<Dim>> parts_of(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps);

/// The poses and features of a part's stretch in the frame of its first pose, from its own observations alone. Its lists of
/// maps and observations stay empty.
template <int Dim>
Piece<Dim> composed(const Part<Dim>& part);

/// The part's single observations, each as a map of one target.
template <int Dim>
std::vector<LocalMap<Dim>> observations_as_maps(const Part<Dim>& part);

/// Whether the part has priors or fixed poses.
template <int Dim>
bool speaks_of_world(const Part<Dim>& part);

/// Parts as one set of maps; poses and features have their index as their key.
template <int Dim>
MapSet<Dim> set_of(const std::vector<const Part<Dim>*>& parts);

/// As that of any set of maps, but for poses inside maps, which are not joined. `set` must outlive it.
template <int Dim>
Network<Dim> network_of_parts(const MapSet<Dim>& set);

}  // namespace mapjoin
