// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Makes a Log out of what a reader finds, in whatever order it comes: sorts poses, tells odometry from closures, finds
// sessions.

#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>

namespace mapjoin {

/// Poses and features are named by the user's ids and come into being when first mentioned. Every information matrix must be
/// finite, symmetric and positive semidefinite (see check_information in io/information.hpp): readers check, for they know the
/// line.
template <int Dim>
class LogBuilder {
 public:
  explicit LogBuilder(std::string source, Conventions conventions = {});

  void add_pose(PoseId id, const std::optional<Pose<Dim>>& initial = std::nullopt);
  void add_feature(FeatureId id, const std::optional<Point<Dim>>& initial = std::nullopt);
  void add_stamp(PoseId id, std::int64_t nanoseconds);

  /// Odometry or closure: which, finish() decides.
  void add_pose_edge(PoseId base, PoseId target, const Pose<Dim>& measured, const PoseMatrix<Dim>& information);
  void add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information);
  void add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information);
  void add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information);
  /// The World holds the pose at `value` or, where none is given, at its initial value, else at the origin.
  void fix(PoseId id, const std::optional<Pose<Dim>>& value = std::nullopt);

  /// The log, with the promises of Log kept. An edge from a pose to itself, a stamp on some poses only, and a log
  /// without poses are bad input. O(n log n).
  Expected<Log<Dim>> finish() &&;

 private:
  // (implementation's business)
};

}  // namespace mapjoin
