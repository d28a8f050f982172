// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far an estimated trajectory is from the true one (ATE, RPE), and how far two maps of the same things are apart.

#include <cstddef>
#include <mapjoin/model/global_map.hpp>
#include <vector>

namespace mapjoin {

/// The size of a set of errors.
struct ErrorSummary {
  std::size_t count = 0;
  double rms = 0.0;
  double max = 0.0;
};

/// Translations in metres, rotations by their angle in radians.
struct PoseErrorSummary {
  ErrorSummary translation;
  ErrorSummary rotation;
};

/// The rigid motion, without scale, that best takes the points `from` onto the points `to` of the same indices, in least
/// squares (Umeyama, PAMI 1991). Throws std::invalid_argument where there are none or their numbers differ.
template <int Dim>
Pose<Dim> align(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

template <int Dim>
struct AbsoluteTrajectoryError {
  Pose<Dim> alignment;      ///< Takes the frame of the estimate into the frame of the truth.
  PoseErrorSummary errors;  ///< Of the aligned estimate; `errors.translation.rms` is what is called ATE.
};

/// Differences, pose by pose, after the positions are aligned by align(). The same preconditions.
template <int Dim>
AbsoluteTrajectoryError<Dim> absolute_trajectory_error(const std::vector<Pose<Dim>>& estimate,
                                                       const std::vector<Pose<Dim>>& truth);

/// Differences of the motions from pose i to pose i + `span`, for every i: the drift over that many steps, whatever the
/// frames. A `span` of 0 is an std::invalid_argument, as are differing numbers of poses.
template <int Dim>
PoseErrorSummary relative_pose_error(const std::vector<Pose<Dim>>& estimate, const std::vector<Pose<Dim>>& truth,
                                     std::size_t span);

/// Differences of what two maps both hold, by id.
struct MapDifference {
  PoseErrorSummary poses;
  ErrorSummary features;
  std::size_t unmatched = 0;  ///< Poses and features that only one of them holds.
};

/// As the maps stand: in one frame, not aligned. Each id is taken once per map.
template <int Dim>
MapDifference map_difference(const GlobalMap<Dim>& a, const GlobalMap<Dim>& b);

}  // namespace mapjoin
