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

/// What a reader left out, and how often: "EQUIV lines", "self-edges".
using SkipCounts = std::map<std::string, std::int64_t, std::less<>>;

/// A pose-pose edge under the names of its ends.
template <int Dim>
struct NamedEdge {
  PoseId base;
  PoseId target;
  Pose<Dim> measured;           ///< Target in the frame of the base.
  PoseMatrix<Dim> information;  ///< As of PoseFactor.
};

/// A log over `poses.size()` poses and `features.size()` features, made by LogBuilder, which keeps what is said here.
template <int Dim>
struct Log {
  std::string source;  ///< The file it was read from, for messages.

  /// Names by index, in the order in which poses were driven: that of their ids or, where they tell it better, of the edges.
  PoseIds poses;
  FeatureIds features;            ///< Names by index, in ascending order.
  std::vector<Session> sessions;  ///< In order; together they hold every pose once.

  /// Pose factors: odometry, closures, priors. Feature factors: observations, priors. Fixed poses: in the order of their pose.
  FactorGraph<Dim> graph;

  Table<PoseIndex, std::int64_t> stamps_ns;  ///< Or empty.
  Values<Dim> initial;                       ///< The file's values; of poses, of features, or of both none unless all have one.

  std::int64_t repeated_edges = 0;      ///< Pose-pose edges beyond the first between the same two poses.
  std::int64_t unassociated = 0;        ///< Observations left out since the file does not say of which feature they are.
  SkipCounts skipped;                   ///< As the reader's options said.
  std::vector<NamedEdge<Dim>> foreign;  ///< Edges to poses of other files (see Undeclared::kForeign); not of this log.
  Conventions conventions;

  /// Odometry, then closures.
  std::span<const PoseFactor<Dim>> edges() const;
  /// Edges between successive poses of a session, either direction, in the order of their later pose. Repeated edges stand
  /// side by side and all count.
  std::span<const PoseFactor<Dim>> odometry() const;
  /// Every other edge, in the order of the file.
  std::span<const PoseFactor<Dim>> closures() const;
  std::span<const PoseFactor<Dim>> pose_priors() const;
  /// In the order of their pose, then of the file.
  std::span<const FeatureFactor<Dim>> observations() const;
  std::span<const FeatureFactor<Dim>> feature_priors() const;
};

/// The log of a file, which decides on the dimension.
using AnyLog = std::variant<Log<2>, Log<3>>;

/// Makes what is said of Log's members true of a log whose poses are in order and whose factors come in any order: sorts them
/// stably, counts repeated edges, finds the sessions. O(n log n).
template <int Dim>
void put_in_order(Log<Dim>& log);

/// Puts the poses, which are in the order of their ids, in that in which a robot drove them. Where edges tie half of the poses
/// or more to the one before, it is the order in which edges first name the poses, if that leaves at most half as many steps
/// without an edge as the order of ids; what stands between two poses that an edge ties goes behind the drives. Else it is that
/// of paths along the edges, if these tie half of the poses or more (PathCover). Within each of the user's sessions; the pose
/// factors are in the order of the file. O(n log n).
template <int Dim>
void take_order_of_edges(Log<Dim>& log);

/// Puts the poses, which are in the order of their ids, in this order; bad input where it does not name each of them once.
template <int Dim>
Expected<void> take_order(const PoseIds& order, Log<Dim>& log);

}  // namespace mapjoin
