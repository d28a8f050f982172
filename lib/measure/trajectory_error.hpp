// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far an estimated trajectory is from the true one (ATE, RPE), and how far two maps of the same things are apart.

#include <cstddef>
#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/global_map.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// The size of a set of errors.
struct ErrorSummary {
  std::size_t count = 0;
  double rms = 0.0;
  double max = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< Of an even number the mean of the two in the middle.
  double min = 0.0;
  double deviation = 0.0;  ///< From the mean: rms² is mean² + deviation².
};
ErrorSummary summary_of(const std::vector<double>& errors);

/// Translations in metres, rotations by their angle in radians.
struct PoseErrorSummary {
  ErrorSummary translation;
  ErrorSummary rotation;
};

/// The rigid motion, without scale, that best takes the points `from` onto the points `to` of the same indices, in least
/// squares (Umeyama, PAMI 1991). Throws std::invalid_argument where there are none or their numbers differ.
template <int Dim>
Pose<Dim> align(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// How an estimate is moved into the frame of the truth.
enum class TrajectoryAlignment : std::uint8_t {
  kRigid,   ///< By align() of all positions.
  kOrigin,  ///< So that the first poses agree.
  kNone,
};
constexpr auto enum_names(TrajectoryAlignment) {
  return std::to_array<EnumName<TrajectoryAlignment>>(
      {{TrajectoryAlignment::kRigid, "rigid"}, {TrajectoryAlignment::kOrigin, "origin"}, {TrajectoryAlignment::kNone, "none"}});
}

template <int Dim>
struct AbsoluteTrajectoryError {
  Pose<Dim> alignment;      ///< Takes the frame of the estimate into the frame of the truth.
  PoseErrorSummary errors;  ///< Of the aligned estimate; `errors.translation.rms` is what is called ATE.
};

/// Differences, pose by pose, after the estimate is aligned. The preconditions of align().
template <int Dim>
AbsoluteTrajectoryError<Dim> absolute_trajectory_error(const std::vector<Pose<Dim>>& estimate,
                                                       const std::vector<Pose<Dim>>& truth,
                                                       TrajectoryAlignment alignment = TrajectoryAlignment::kRigid);

/// Poses, by their positions in a trajectory, between which motions are compared.
using PosePairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// Which pairs of poses a span apart are compared.
enum class SpanPairs : std::uint8_t {
  kAll,         ///< From every pose.
  kSuccessive,  ///< From the pose where the pair before ends.
};
constexpr auto enum_names(SpanPairs) {
  return std::to_array<EnumName<SpanPairs>>({{SpanPairs::kAll, "all"}, {SpanPairs::kSuccessive, "successive"}});
}

/// The pairs of `poses` poses so many steps apart. A `span` of 0 is an std::invalid_argument.
PosePairs pairs_by_steps(std::size_t poses, std::size_t span, SpanPairs which = SpanPairs::kAll);
/// The pairs so many metres of the way apart: from every pose to the one that comes nearest to that, if to a tenth; or between
/// the poses where so much, and again so much, was travelled.
template <int Dim>
PosePairs pairs_by_path(const std::vector<Pose<Dim>>& poses, double metres, SpanPairs which = SpanPairs::kAll);

/// Differences of the motions between pairs of poses, whatever the frames: the drift over a span (RPE), or the metric of
/// Kümmerle and others ("On measuring the accuracy of SLAM algorithms", 2009) where the pairs are relations of the truth.
/// Differing numbers of poses are an std::invalid_argument.
template <int Dim>
PoseErrorSummary relative_pose_error(const std::vector<Pose<Dim>>& estimate, const std::vector<Pose<Dim>>& truth,
                                     const PosePairs& pairs);

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
