// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Builds a Log from what a reader finds, in any order: sorts poses, tells odometry from closures, finds sessions.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/name_table.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace mapjoin {

/// The place where the numbers of a log are checked.
enum class Numbers : std::uint8_t {
  kUnchecked,  ///< LogBuilder::finish() checks them.
  kChecked,    ///< A reader has checked them, line by line.
};

/// The order of the poses of a log.
enum class PoseOrder : std::uint8_t {
  kDriven,  ///< Driving order: that of the ids or, if they fit better, of the edges (see take_order_of_edges).
  kOfIds,   ///< The order of the ids, whatever the edges say: for a log that grows.
};

/// What is taken out of a log.
template <int Dim>
struct LeftOut {
  std::vector<NamedEdge<Dim>> edges;  ///< Pose-pose edges.
  std::int64_t others = 0;            ///< Number of other factors.
  std::int64_t fixed_poses = 0;

  std::int64_t factor_count() const { return static_cast<std::int64_t>(edges.size()) + others; }
};

/// Builds a log. Poses and features are named by the user's ids and created when first mentioned.
template <int Dim>
class LogBuilder {
 public:
  explicit LogBuilder(std::string source, Conventions conventions = {}, Numbers numbers = Numbers::kUnchecked)
      : numbers_(numbers) {
    log_.source = std::move(source);
    log_.conventions = conventions;
  }

  /// Reserves room for so many pose-pose edges and observations, if a reader knows them beforehand.
  void reserve(std::size_t pose_edges, std::size_t observations) {
    poses_.reserve(pose_edges);
    features_.reserve(observations);
  }

  void add_pose(PoseId id, const std::optional<Pose<Dim>>& initial = std::nullopt) { poses_.add(id, initial); }
  void add_feature(FeatureId id, const std::optional<Point<Dim>>& initial = std::nullopt) { features_.add(id, initial); }
  void add_stamp(PoseId id, std::int64_t nanoseconds) {
    poses_.names.mention(id);
    stamps_.push_back({id, nanoseconds});
  }
  /// Counts observations left out because the input does not name their feature.
  void add_unassociated(std::int64_t count = 1) { log_.unassociated += count; }
  /// Counts entries of the kind `what` that the reader's options leave out.
  void add_skipped(std::string_view what, std::int64_t count = 1) {
    const auto known = log_.skipped.find(what);
    (known != log_.skipped.end() ? known->second : log_.skipped[std::string(what)]) += count;
  }
  /// Adds a reader's repairs of matrices that it added.
  void add_repairs(const MatrixRepairs& repairs) { log_.conventions.repairs += repairs; }
  /// Lets finish() build a log without poses, as some lines of a file may be.
  void allow_no_poses() { needs_poses_ = false; }
  /// Appends the input of another builder, as if it were added next.
  void append(const LogBuilder& other);
  /// Appends a log without its foreign edges, its session n as session `first_session` + n, and adds its repairs to those in
  /// the builder's conventions (see without_repairs()). Throws std::out_of_range if a factor refers to what the log does not
  /// have, or its sessions go beyond 2^32.
  void append(const Log<Dim>& log, std::uint32_t first_session = 0);
  /// Removes poses and features without an initial value, with their time stamps, and returns what refers to them.
  LeftOut<Dim> take_undeclared();
  /// Forgets poses and features that no factor names, with their values, time stamps and fixing, and where poses are fixed
  /// without a value, all but the first.
  void forget_loose();

  /// Adds odometry or a closure; finish() decides which it is.
  void add_pose_edge(PoseId base, PoseId target, const Pose<Dim>& measured, const PoseMatrix<Dim>& information) {
    add(base, target, PoseFactor<Dim>{0, 0, measured, information});
  }
  void add_observation(PoseId pose, FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information) {
    add(pose, feature, FeatureFactor<Dim>{0, 0, measured, information});
  }
  void add_pose_prior(PoseId pose, const Pose<Dim>& measured, const PoseMatrix<Dim>& information,
                      const Point<Dim>& lever = Point<Dim>::Zero()) {
    add(std::nullopt, pose, PoseFactor<Dim>{kWorld, 0, measured, information, {}, lever});
  }
  void add_feature_prior(FeatureId feature, const Point<Dim>& measured, const PointMatrix<Dim>& information) {
    add(std::nullopt, feature, FeatureFactor<Dim>{kWorld, 0, measured, information});
  }
  /// Adds a factor as it is, except for its ends, which are given by name; `base` is nullopt for the World.
  void add(std::optional<PoseId> base, PoseId target, const PoseFactor<Dim>& factor) { add_to(poses_, base, target, factor); }
  void add(std::optional<PoseId> base, FeatureId target, const FeatureFactor<Dim>& factor) {
    add_to(features_, base, target, factor);
  }
  /// Fixes a pose, which must be mentioned elsewhere, at `value` or, if none is given, at its initial value; one pose without
  /// either is anchored at the origin.
  void fix(PoseId id, const std::optional<Pose<Dim>>& value = std::nullopt) { fixed_.push_back({id, value}); }
  /// The ids of the poses that fix() was called with, ascending, each once.
  std::vector<PoseId> fixed_poses() const;

  /// The log, with Log's invariants. kBadInput: an edge from a pose to itself, a pose or feature with two initial values, a
  /// pose with two stamps, stamps on some poses only, a pose that is fixed at two places or mentioned only by its fixing, a
  /// second fixed pose without a value, a log without poses; a number that is not finite, a quaternion that is not of unit
  /// length, and an information matrix that InformationCheck refuses. kTooLarge from 2^31 - 1 poses or features on. The builder
  /// is left as LogBuilder(source) makes one, also after an error. O(n log n).
  Expected<Log<Dim>> finish(PoseOrder order = PoseOrder::kDriven) &&;
  /// The log with its poses in this order; kBadInput also if it does not name each of them once.
  Expected<Log<Dim>> finish(const PoseIds& order) &&;

 private:
  /// A value given for the pose or feature `id`.
  template <typename Id, typename Value>
  struct Said {
    Id id;
    Value value;
  };
  /// The input on poses, or on features.
  template <typename Id, typename Value, typename Factor>
  struct Kind {
    NameTable<Id> names;
    std::vector<Factor> factors;  ///< In the order of the file; their ends other than the World are not yet indices.
    std::vector<std::pair<PoseId, Id>> ends{};  ///< Base and target of each factor; the World has no name.
    std::vector<Said<Id, Value>> initial{};

    void add(Id id, const std::optional<Value>& value) {
      names.mention(id);
      if (value) initial.push_back({id, *value});
    }
    void add(PoseId base, Id target, const Factor& factor) {
      names.mention(target);
      ends.emplace_back(base, target);
      factors.push_back(factor);
    }
    void append(const Kind& other);
    void reserve(std::size_t count) {
      ends.reserve(count);
      factors.reserve(count);
    }
  };

  template <typename Kind, typename Id, typename Factor>
  void add_to(Kind& kind, std::optional<PoseId> base, Id target, Factor factor) {
    if (base) poses_.names.mention(*base);
    factor.base = base ? PoseIndex(0) : kWorld;
    kind.add(base.value_or(PoseId{}), target, factor);
  }
  template <typename F>
  Expected<Log<Dim>> finish_with(F&& order_poses);
  Expected<void> check_names() const;
  Expected<void> check_edges() const;
  Expected<void> check_numbers();
  void resolve_ends();
  Expected<void> resolve_values();
  Expected<std::vector<FixedPose<Dim>>> resolve_fixed() const;

  Numbers numbers_;
  bool needs_poses_ = true;
  Log<Dim> log_;
  Kind<PoseId, Pose<Dim>, PoseFactor<Dim>> poses_;
  Kind<FeatureId, Point<Dim>, FeatureFactor<Dim>> features_;
  std::vector<Said<PoseId, std::int64_t>> stamps_;
  std::vector<Said<PoseId, std::optional<Pose<Dim>>>> fixed_;
};

}  // namespace mapjoin
