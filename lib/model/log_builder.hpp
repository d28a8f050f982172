// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Makes a Log out of what a reader finds, in whatever order it comes: sorts poses, tells odometry from closures, finds
// sessions.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/name_table.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {

/// Who checks the numbers of a log.
enum class Numbers : std::uint8_t {
  kUnchecked,  ///< LogBuilder::finish().
  kChecked,    ///< A reader has, line by line.
};

/// In which order the poses of a log come.
enum class PoseOrder : std::uint8_t {
  kDriven,  ///< That of their ids or, where these say nothing of it, of the edges (see take_order_of_edges).
  kOfIds,   ///< That of their ids, whatever the edges say: for a log that grows.
};

/// Poses and features are named by the user's ids and come into being when first mentioned.
template <int Dim>
class LogBuilder {
 public:
  explicit LogBuilder(std::string source, Conventions conventions = {}, Numbers numbers = Numbers::kUnchecked);

  /// Makes room for so many pose-pose edges and observations, where a reader knows beforehand.
  void reserve(std::size_t pose_edges, std::size_t observations);

  void add_pose(PoseId id, const std::optional<Pose<Dim>>& initial = std::nullopt);
  void add_feature(FeatureId id, const std::optional<Point<Dim>>& initial = std::nullopt);
  void add_stamp(PoseId id, std::int64_t nanoseconds);
  /// Observations that are left out since the input does not say of which feature they are.
  void add_unassociated(std::int64_t count = 1) { log_.unassociated += count; }
  /// What a reader did to matrices before it added them.
  void add_repairs(const MatrixRepairs& repairs) { log_.conventions.repairs += repairs; }
  /// What another builder was told, as if this one was told it next.
  void append(const LogBuilder& other);

  /// Odometry or closure: which, finish() decides.
  void add_pose_edge(PoseId base, PoseId target, const Pose<Dim>& measured, const PoseMatrix<Dim>& information);
  void add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information);
  void add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information);
  void add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information);
  /// The World holds the pose, which must be mentioned elsewhere, at `value` or, where none is given, at its initial value; one
  /// pose without either is anchored at the origin.
  void fix(PoseId id, const std::optional<Pose<Dim>>& value = std::nullopt);

  /// The log, with the promises of Log kept. Bad input are: an edge from a pose to itself, a pose or feature with two initial
  /// values, a pose with two stamps, stamps on some poses only, a pose that is fixed at two places or that nothing but its
  /// fixing mentions, a second fixed pose without a value, a log without poses; a number that is not finite, a quaternion that
  /// is not of unit length, and an information matrix that InformationCheck refuses. O(n log n).
  Expected<Log<Dim>> finish(PoseOrder order = PoseOrder::kDriven) &&;

 private:
  template <typename Id>
  using Ends = std::vector<std::pair<PoseId, Id>>;
  /// Something said of the pose or feature `id`.
  template <typename Id, typename Value>
  struct Said {
    Id id;
    Value value;
  };
  /// What was said of each pose or feature.
  template <typename Index, typename Value>
  struct Column {
    Table<Index, Value> values;
    Table<Index, bool> given;
    std::size_t count = 0;
  };
  template <typename Index, typename Value, typename Id>
  static Expected<Column<Index, Value>> column_of(const std::vector<Said<Id, Value>>& said, const Table<Index, Id>& names,
                                                  const char* what);

  Expected<void> check_names() const;
  Expected<void> check_edges() const;
  Expected<void> check_numbers();
  Expected<void> check_values() const;
  void resolve_ends();
  Expected<void> resolve_values();
  Expected<std::vector<FixedPose<Dim>>> resolve_fixed(const Column<PoseIndex, Pose<Dim>>& initial_poses) const;

  Numbers numbers_;
  Log<Dim> log_;  ///< Factors wait here in the order of the file; their ends but the World are not yet indices.
  NameTable<PoseId> poses_;
  NameTable<FeatureId> features_;
  Ends<PoseId> pose_ends_;  ///< Of the factors; a prior has the World as its base already, and no name for it.
  Ends<FeatureId> feature_ends_;
  std::vector<Said<PoseId, Pose<Dim>>> initial_poses_;
  std::vector<Said<FeatureId, Point<Dim>>> initial_features_;
  std::vector<Said<PoseId, std::int64_t>> stamps_;
  std::vector<Said<PoseId, std::optional<Pose<Dim>>>> fixed_;
};

}  // namespace mapjoin
