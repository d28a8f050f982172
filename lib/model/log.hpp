// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A robot's log: poses in the order they were driven, odometry, closures, feature observations, and what the World says.

#include <cstdint>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/observation.hpp>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// Successive poses [begin, end) that odometry ties together. A missing odometry edge starts the next session.
struct Session {
  Index begin = 0;
  Index end = 0;
};

/// A pose that the World holds still.
template <int Dim>
struct FixedPose {
  Index pose = 0;
  Pose<Dim> value;  ///< In the World frame.
};

/// A log over `poses.size()` poses and `features.size()` features, made by LogBuilder, which keeps what is said here.
template <int Dim>
struct Log {
  std::string source;  ///< The file it was read from, for messages.

  /// Names by index, in the order in which poses were driven: that of their ids or, where these say nothing of it, of the
  /// edges.
  std::vector<PoseId> poses;
  std::vector<FeatureId> features;  ///< Names by index, in ascending order.
  std::vector<Session> sessions;    ///< In order; together they hold every pose once.

  /// Edges between successive poses of a session, either direction, in the order of their later pose. Repeated edges stand
  /// side by side and all count.
  std::vector<PoseObservation<Dim>> odometry;
  std::vector<PoseObservation<Dim>> closures;           ///< Every other pose-pose edge, in the order of the file.
  std::vector<FeatureObservation<Dim>> observations;    ///< In the order of their pose, then of the file.
  std::vector<PoseObservation<Dim>> pose_priors;        ///< From the World.
  std::vector<FeatureObservation<Dim>> feature_priors;  ///< From the World.
  std::vector<FixedPose<Dim>> fixed;                    ///< In the order of their pose; each pose once.

  std::vector<std::int64_t> stamps_ns;       ///< Per pose, or empty.
  std::vector<Pose<Dim>> initial_poses;      ///< The file's values per pose, or empty unless every pose has one.
  std::vector<Point<Dim>> initial_features;  ///< The file's values per feature, or empty unless every one has one.

  std::int64_t repeated_edges = 0;  ///< Pose-pose edges beyond the first between the same two poses.
  std::int64_t unassociated = 0;    ///< Observations left out since the file does not say of which feature they are.
  Conventions conventions;
};

/// The log of a file, which decides on the dimension.
using AnyLog = std::variant<Log<2>, Log<3>>;

/// Where fewer than half of the steps from id to id, which are in ascending order, have an edge, and paths along the edges tie
/// half of the poses or more (PathCover, within each of the user's sessions): puts the poses in their order. `log.odometry`
/// holds all pose-pose edges, in the order of the file. O(n log n).
template <int Dim>
void take_order_of_edges(Log<Dim>& log);

/// Makes what is said of Log's members true of a log whose poses are in order, whose odometry holds all pose-pose edges and
/// whose observations come in any order: parts and sorts them stably, counts repeated edges, finds the sessions. O(n log n).
template <int Dim>
void put_in_order(Log<Dim>& log);

/// Every information matrix replaced by the identity, in place; the conventions say so (paper's Table I).
template <int Dim>
void use_identity_covariance(Log<Dim>& log);

}  // namespace mapjoin
