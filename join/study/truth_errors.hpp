// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The errors of a map against a truth that is known of some of its poses and features.

#include <cstdint>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>

namespace mapjoin {

/// The rigid motion that best takes a map onto its truth, by the positions of all poses and features whose truth is known;
/// nullopt if these leave a rotation free.
template <int Dim>
std::optional<Pose<Dim>> alignment_onto(const Truth<Dim>& truth, const GlobalMap<Dim>& map);

/// The positions by which a map was aligned with its truth.
enum class AlignedBy : std::uint8_t {
  kPoses,     ///< Those of poses, or of the first one alone, or no positions, as TrajectoryAlignment says.
  kFeatures,  ///< Those of features, too, since those of poses leave a rotation free: a straight line in space, say.
  kTooLittle  ///< The same, but a rotation is still free.
};

struct AbsoluteErrors {
  PoseErrorSummary poses;  ///< Errors of the poses whose truth is known; none of rotations if one is free.
  ErrorSummary features;   ///< Errors of features, moved as the poses; none if a rotation is free.
  AlignedBy aligned_by = AlignedBy::kPoses;
};

/// The errors of a map, aligned with its truth; all of them empty if the truth has none of its poses.
template <int Dim>
AbsoluteErrors absolute_errors(const GlobalMap<Dim>& map, const Truth<Dim>& truth,
                               TrajectoryAlignment alignment = TrajectoryAlignment::kRigid);

/// The pairs of poses of each session (sessions_by_name()): those that `pairs_of(session)` gives, counted from its first pose.
template <typename PairsOf>
PosePairs pairs_within_sessions(const PoseIds& poses, const PairsOf& pairs_of) {
  PosePairs pairs;
  for (const Session& session : sessions_by_name(poses)) {
    const std::size_t first = session.begin.position();
    for (const auto& [i, j] : pairs_of(session)) pairs.emplace_back(first + i, first + j);
  }
  return pairs;
}

/// The errors of the motions between pairs of poses of the map (relative_pose_error()), of the pairs both of whose poses the
/// truth knows.
template <int Dim>
PoseErrorSummary relative_errors(const GlobalMap<Dim>& map, const Truth<Dim>& truth, PosePairs pairs);

}  // namespace mapjoin
