// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The joined map: poses and features in one frame, with its gauge and the conventions of its chi2.

#include <algorithm>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// Poses and features in one frame; lengths in metres, angles in radians, headings of a joined map in (-π, π].
template <int Dim>
struct GlobalMap {
  PoseIds pose_ids;
  Table<PoseIndex, Pose<Dim>> poses;
  FeatureIds feature_ids;
  Table<FeatureIndex, Point<Dim>> features;
  Table<PoseIndex, std::int64_t> stamps_ns;  ///< Time stamps; empty if unknown.
  std::vector<PoseIndex> gauge;              ///< The anchored poses; empty if priors fix the gauge.

  /// Marginal covariances of the steps, relative to the gauge: per pose (zero if anchored) and per feature; empty if unknown.
  Table<PoseIndex, PoseMatrix<Dim>> pose_covariances;
  Table<FeatureIndex, PointMatrix<Dim>> feature_covariances;
  Conventions conventions;
};

/// Takes whole turns off the headings in the plane, which are then in (-π, π]: how often a robot turned on the way to a pose
/// depends on the order in which maps were joined.
template <int Dim>
void take_off_turns(GlobalMap<Dim>& map) {
  if constexpr (Dim == 2) {
    for (Pose<2>& pose : map.poses) pose.rotation = pose.rotation.without_turns();
  }
}

/// True if the values of all poses and features are valid.
template <int Dim>
bool is_valid(const GlobalMap<Dim>& map) {
  const auto is_sound = [](const auto& value) { return is_valid(value); };
  return std::ranges::all_of(map.poses, is_sound) && std::ranges::all_of(map.features, is_sound);
}

}  // namespace mapjoin
