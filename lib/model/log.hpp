// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A robot's log: poses in the order they were driven, and the factor graph of its odometry, closures and observations.

#include <cstdint>
#include <functional>
#include <map>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/factor_graph.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/values.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// Successive poses [begin, end) that odometry ties together. A missing odometry edge starts the next session.
struct Session {
  PoseIndex begin = 0;
  PoseIndex end = 0;
};

/// The sessions of poses that no odometry ties, by their names: those of one robot, one after the other, are taken for its
/// path.
std::vector<Session> sessions_by_name(const PoseIds& poses);

/// Counts of what a reader left out, by kind: "EQUIV lines", "self-edges".
using SkipCounts = std::map<std::string, std::int64_t, std::less<>>;

/// A pose-pose edge with its ends by name.
template <int Dim>
struct NamedEdge {
  PoseId base;
  PoseId target;
  Pose<Dim> measured;           ///< Target in the frame of the base.
  PoseMatrix<Dim> information;  ///< As in PoseFactor.
};

/// A log over `poses.size()` poses and `features.size()` features, made by LogBuilder, which establishes the invariants stated
/// here (see check_invariants()).
template <int Dim>
struct Log {
  std::string source;  ///< The file it was read from, for messages.

  /// Names by index, in driving order: that of the ids or, if they fit better, of the edges (see take_order_of_edges).
  PoseIds poses;
  FeatureIds features;            ///< Names by index, in ascending order.
  std::vector<Session> sessions;  ///< In order; together they hold every pose once.

  /// Pose factors: odometry, closures, priors. Feature factors: observations, priors. Fixed poses: in the order of their pose.
  FactorGraph<Dim> graph;

  Table<PoseIndex, std::int64_t> stamps_ns;  ///< Time stamps; empty if unknown.
  Values<Dim> initial;                       ///< The file's values: of poses, or of features, only if all of them have one.

  std::int64_t repeated_edges = 0;      ///< Pose-pose edges beyond the first between the same two poses.
  std::int64_t unassociated = 0;        ///< Observations left out because the file does not name their feature.
  SkipCounts skipped;                   ///< Entries left out as options demand, by kind.
  std::vector<NamedEdge<Dim>> foreign;  ///< Edges to poses of other files (see Undeclared::kForeign), not part of the log.
  Conventions conventions;

  /// Odometry, then closures.
  std::span<const PoseFactor<Dim>> edges() const;
  /// Edges between successive poses of a session, either direction, in the order of their later pose. Repeated edges stand
  /// side by side and all count.
  std::span<const PoseFactor<Dim>> odometry() const;
  /// Edges that are not odometry, in the order of the file.
  std::span<const PoseFactor<Dim>> closures() const;
  std::span<const PoseFactor<Dim>> pose_priors() const;
  /// Observations of features, in the order of their pose, then of the file.
  std::span<const FeatureFactor<Dim>> observations() const;
  std::span<const FeatureFactor<Dim>> feature_priors() const;
  /// True if fixed poses or priors hold the log in the World.
  bool is_held() const;
};

/// The log of a file, in the dimension that the file has.
using AnyLog = std::variant<Log<2>, Log<3>>;

/// Establishes Log's invariants for a log whose poses are in order and whose factors come in any order: sorts them stably,
/// counts repeated edges, finds the sessions. O(n log n).
template <int Dim>
void put_in_order(Log<Dim>& log);

/// Checks a log that was made or changed without LogBuilder. kBadInput unless there are poses; each is named once, and so
/// is each feature; factors and fixed poses are of poses and features of the log and in order, factors between two different
/// ones; sessions hold every pose once, in order; stamps and initial values are of all or of none; numbers are those that
/// LogBuilder takes, or a factor is dropped by its loss; and there are no local maps. O(n), O(n log n) where poses are not in
/// the order of their names.
template <int Dim>
Expected<void> check_invariants(const Log<Dim>& log);

/// Puts the poses, which are in the order of their ids, in driving order, within each of the user's sessions. If edges tie half
/// of the poses or more to the one before, that is the order in which edges first name the poses, provided that it leaves at
/// most half as many steps without an edge as the order of ids; poses between two that an edge ties go behind the drives.
/// Otherwise it is the order of paths along the edges (PathCover), provided that these tie half of the poses or more. The pose
/// factors are in the order of the file. O(n log n).
template <int Dim>
void take_order_of_edges(Log<Dim>& log);

/// Puts the poses, which are in the order of their ids, in this order; kBadInput if it does not name each of them once.
template <int Dim>
Expected<void> take_order(const PoseIds& order, Log<Dim>& log);

}  // namespace mapjoin
