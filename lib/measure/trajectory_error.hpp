// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Errors of an estimated trajectory (ATE, RPE), and differences of two maps of the same things.

#include <cstddef>
#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/global_map.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// Statistics of a set of errors.
struct ErrorSummary {
  std::size_t count = 0;
  double rms = 0.0;
  double max = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< The mean of the two in the middle if the count is even.
  double min = 0.0;
  double deviation = 0.0;  ///< Standard deviation: rms² is mean² + deviation².
};
ErrorSummary summary_of(const std::vector<double>& errors);

/// Errors of poses: translations in metres, rotations by their angle in radians.
struct PoseErrorSummary {
  ErrorSummary translation;
  ErrorSummary rotation;
};

/// The rotation R that maximises tr(Rᵀ C).
Rotation<2> nearest_rotation(const PointMatrix<2>& C);
Rotation<3> nearest_rotation(const PointMatrix<3>& C);

/// The rigid motion, without scale, that takes the points `from` to the points `to` of the same indices, in least squares
/// (Umeyama, PAMI 1991). Throws std::invalid_argument if there are none or their numbers differ.
template <int Dim>
Pose<Dim> align(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// The alignment of an estimate with the frame of the truth.
enum class TrajectoryAlignment : std::uint8_t {
  kRigid,   ///< The rigid motion of align() over all positions.
  kOrigin,  ///< The motion that makes the first poses agree.
  kNone,
};
constexpr auto enum_names(TrajectoryAlignment) {
  return std::to_array<EnumName<TrajectoryAlignment>>(
      {{TrajectoryAlignment::kRigid, "rigid"}, {TrajectoryAlignment::kOrigin, "origin"}, {TrajectoryAlignment::kNone, "none"}});
}

template <int Dim>
struct AbsoluteTrajectoryError {
  Pose<Dim> alignment;      ///< Takes the frame of the estimate into the frame of the truth.
  PoseErrorSummary errors;  ///< Errors of the aligned estimate; `errors.translation.rms` is the ATE.
};

/// Errors pose by pose, after alignment of the estimate. Preconditions as of align().
template <int Dim>
AbsoluteTrajectoryError<Dim> absolute_trajectory_error(const std::vector<Pose<Dim>>& estimate,
                                                       const std::vector<Pose<Dim>>& truth,
                                                       TrajectoryAlignment alignment = TrajectoryAlignment::kRigid);

/// Pairs of poses, by their positions in a trajectory, between which motions are compared.
using PosePairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// The pairs of poses a span apart that are compared.
enum class SpanPairs : std::uint8_t {
  kAll,         ///< A pair from every pose.
  kSuccessive,  ///< A pair from the pose where the one before ends.
};
constexpr auto enum_names(SpanPairs) {
  return std::to_array<EnumName<SpanPairs>>({{SpanPairs::kAll, "all"}, {SpanPairs::kSuccessive, "successive"}});
}

/// The pairs of `poses` poses that are `span` steps apart. Throws std::invalid_argument if `span` is 0.
PosePairs pairs_by_steps(std::size_t poses, std::size_t span, SpanPairs which = SpanPairs::kAll);
/// The pairs of poses that are `metres` of path apart: from every pose to the one whose path length comes nearest, if within a
/// tenth; or between successive poses each of which lies `metres` or just more behind the one before.
template <int Dim>
PosePairs pairs_by_path(const std::vector<Pose<Dim>>& poses, double metres, SpanPairs which = SpanPairs::kAll);

/// Errors of the motions between pairs of poses, independent of the frames: the drift over a span (RPE) or, if the pairs are
/// relations of the truth, the metric of Kümmerle and others ("On measuring the accuracy of SLAM algorithms", 2009). Throws
/// std::invalid_argument if the numbers of poses differ, or a pair has a pose that is not there.
template <int Dim>
PoseErrorSummary relative_pose_error(const std::vector<Pose<Dim>>& estimate, const std::vector<Pose<Dim>>& truth,
                                     const PosePairs& pairs);

/// Differences of the poses and features that two maps have in common, by id.
struct MapDifference {
  PoseErrorSummary poses;
  ErrorSummary features;
  std::size_t unmatched = 0;  ///< Poses and features that only one of the maps has.
};

/// The difference of two maps in one frame, without alignment. Ids must be unique in each map.
template <int Dim>
MapDifference map_difference(const GlobalMap<Dim>& a, const GlobalMap<Dim>& b);

}  // namespace mapjoin
