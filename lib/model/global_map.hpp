// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The result: poses and features in one frame, which says what holds it still and in which convention its chi2 is meant.

#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// Lengths are in metres, angles in radians.
template <int Dim>
struct GlobalMap {
  PoseIds pose_ids;
  Table<PoseIndex, Pose<Dim>> poses;
  FeatureIds feature_ids;
  Table<FeatureIndex, Point<Dim>> features;
  Table<PoseIndex, std::int64_t> stamps_ns;  ///< Or empty.
  std::vector<PoseIndex> gauge;              ///< The poses anchored; empty where priors of the World hold the map.

  /// Marginal covariances of the steps, relative to the gauge: per pose (zero where it is anchored) and per feature, or empty.
  Table<PoseIndex, PoseMatrix<Dim>> pose_covariances;
  Table<FeatureIndex, PointMatrix<Dim>> feature_covariances;
  Conventions conventions;
};

}  // namespace mapjoin
