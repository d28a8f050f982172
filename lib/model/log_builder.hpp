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
#include <string_view>
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
  kDriven,  ///< That of their ids or, where they tell it better, of the edges (see take_order_of_edges).
  kOfIds,   ///< That of their ids, whatever the edges say: for a log that grows.
};

/// Edges, observations and priors that are taken out of a log.
template <int Dim>
struct LeftOut {
  std::vector<NamedEdge<Dim>> edges;  ///< Between poses.
  std::int64_t others = 0;

  std::int64_t count() const { return static_cast<std::int64_t>(edges.size()) + others; }
};

/// Poses and features are named by the user's ids and come into being when first mentioned.
template <int Dim>
class LogBuilder {
 public:
  explicit LogBuilder(std::string source, Conventions conventions = {}, Numbers numbers = Numbers::kUnchecked)
      : numbers_(numbers) {
    log_.source = std::move(source);
    log_.conventions = conventions;
  }

  /// Makes room for so many pose-pose edges and observations, where a reader knows beforehand.
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
  /// Observations that are left out since the input does not say of which feature they are.
  void add_unassociated(std::int64_t count = 1) { log_.unassociated += count; }
  /// What is left out as the reader's options say.
  void add_skipped(std::string_view what, std::int64_t count = 1) {
    const auto known = log_.skipped.find(what);
    (known != log_.skipped.end() ? known->second : log_.skipped[std::string(what)]) += count;
  }
  /// What a reader did to matrices before it added them.
  void add_repairs(const MatrixRepairs& repairs) { log_.conventions.repairs += repairs; }
  /// What another builder was told, as if this one was told it next.
  void append(const LogBuilder& other);
  /// What a log says, its session n as session `first_session` + n; its foreign edges are passed over. std::out_of_range where
  /// a factor names what the log does not have, or its sessions go beyond 2^32.
  void append(const Log<Dim>& log, std::uint32_t first_session = 0);
  /// Takes out what concerns poses and features without an initial value, which it forgets.
  LeftOut<Dim> take_undeclared();

  /// Odometry or closure: which, finish() decides.
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
  /// A factor as it is, but for its ends, which are named; nothing stands for the World.
  void add(std::optional<PoseId> base, PoseId target, const PoseFactor<Dim>& factor) { add_to(poses_, base, target, factor); }
  void add(std::optional<PoseId> base, FeatureId target, const FeatureFactor<Dim>& factor) {
    add_to(features_, base, target, factor);
  }
  /// The World holds the pose, which must be mentioned elsewhere, at `value` or, where none is given, at its initial value; one
  /// pose without either is anchored at the origin.
  void fix(PoseId id, const std::optional<Pose<Dim>>& value = std::nullopt) { fixed_.push_back({id, value}); }

  /// The log, with the promises of Log kept. Bad input are: an edge from a pose to itself, a pose or feature with two initial
  /// values, a pose with two stamps, stamps on some poses only, a pose that is fixed at two places or that nothing but its
  /// fixing mentions, a second fixed pose without a value, a log without poses; a number that is not finite, a quaternion that
  /// is not of unit length, and an information matrix that InformationCheck refuses. O(n log n).
  Expected<Log<Dim>> finish(PoseOrder order = PoseOrder::kDriven) &&;
  /// The same with the poses in this order; bad input where it does not name each of them once.
  Expected<Log<Dim>> finish(const PoseIds& order) &&;

 private:
  /// Something said of the pose or feature `id`.
  template <typename Id, typename Value>
  struct Said {
    Id id;
    Value value;
  };
  /// What was said of poses, or of features.
  template <typename Id, typename Value, typename Factor>
  struct Kind {
    NameTable<Id> names;
    std::vector<Factor> factors;                ///< In the order of the file; their ends but the World are not yet indices.
    std::vector<std::pair<PoseId, Id>> ends{};  ///< Of the factors; the World has no name.
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
  Log<Dim> log_;
  Kind<PoseId, Pose<Dim>, PoseFactor<Dim>> poses_;
  Kind<FeatureId, Point<Dim>, FeatureFactor<Dim>> features_;
  std::vector<Said<PoseId, std::int64_t>> stamps_;
  std::vector<Said<PoseId, std::optional<Pose<Dim>>>> fixed_;
};

}  // namespace mapjoin
