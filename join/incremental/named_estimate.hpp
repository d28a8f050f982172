// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The estimate of an incremental join by the names of poses and features, which updates enter, and the waiting updates that
// names tie to it.

#include <cstddef>
#include <deque>
#include <map>
#include <mapjoin/join/incremental/incremental_estimate.hpp>
#include <mapjoin/join/incremental/joined_snapshot.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/join/join.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// The poses and features of a set where a join has them; both must outlive this.
template <int Dim>
struct JoinedSet {
  JoinedSet(const SubmapSet<Dim>& set, const Join<Dim>& joined)
      : pose_index(set.poses), feature_index(set.features), state(joined.state), is_anchored(set.poses.size(), false) {
    for (const PoseIndex p : joined.anchored) is_anchored[p] = true;
  }

  IndexOf<PoseIndex, PoseId> pose_index;
  IndexOf<FeatureIndex, FeatureId> feature_index;
  const Values<Dim>& state;
  Table<PoseIndex, bool> is_anchored;
};

/// An incremental estimate by names. Poses and features that no update has entered are unknown.
template <int Dim>
class NamedEstimate {
 public:
  /// The estimate of a pose or feature; null if unknown.
  const Pose<Dim>* pose(const PoseId& id) const;
  const Point<Dim>* feature(const FeatureId& id) const;
  bool is_empty() const { return estimate_.variables().empty(); }
  double chi2() const { return estimate_.chi2(); }
  std::int64_t dof() const { return estimate_.dof(); }

  /// Enters the new poses and features of an update where its measurements cost least, and its factors; `update` must outlive
  /// this. Returns the variables of its partial map; nullopt, with the estimate as it was, if the update shares too little with
  /// it.
  std::optional<std::vector<JoinedIndex>> enter(const SubmapUpdate<Dim>& update);
  /// Enters the new poses and features of an update at their values in a join of all, and its factors.
  void enter_at(const SubmapUpdate<Dim>& update, const JoinedSet<Dim>& joined);

  /// The number of poses and features that an update names and this knows.
  std::size_t shared_with(const SubmapUpdate<Dim>& update) const;

  /// Removes the factors of an update that was entered; its poses and features stay, to be entered again with it.
  void leave(const SubmapUpdate<Dim>& update);

  std::optional<Settling> defer() { return estimate_.defer(); }
  Settling settle(std::span<const JoinedIndex> last) { return estimate_.settle(last); }
  /// The estimate as of the last settling or deferral.
  std::shared_ptr<const JoinedSnapshot<Dim>> snapshot();
  /// The largest move of a pose or feature from `before` to this, of those in both.
  StepSize moved_from(const NamedEstimate& before) const;

 private:
  /// The estimate of a pose by the update's own index; null if it is unknown or the World, which is no pose.
  const Pose<Dim>* pose(const SubmapUpdate<Dim>& update, PoseIndex p) const {
    return p == kWorld ? nullptr : pose(update.poses[p]);
  }
  const Point<Dim>* feature(const SubmapUpdate<Dim>& update, FeatureIndex f) const { return feature(update.features[f]); }
  std::vector<Pose<Dim>> alignments(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const;
  bool knows_ends(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const;
  JoinedIndex enter_pose(const PoseId& id, const Pose<Dim>& value, bool is_anchored);
  JoinedIndex enter_feature(const FeatureId& id, const Point<Dim>& value);
  void enter_late_features(const SubmapUpdate<Dim>& update);
  std::vector<MapFactor<Dim>> factors_of(const SubmapUpdate<Dim>& update);
  void add_factors(const SubmapUpdate<Dim>& update, std::vector<MapFactor<Dim>> factors);

  IncrementalEstimate<Dim> estimate_;
  std::shared_ptr<JoinedNames> names_ = std::make_shared<JoinedNames>();
  std::deque<LocalMap<Dim>> singles_;  // single observations as maps of one target
  std::map<const SubmapUpdate<Dim>*, std::vector<FactorIndex>> factors_;
};

/// The updates with the numbers `waiting` that names tie to the estimate, if only by way of each other, in one group; if the
/// estimate is empty, groups of updates that names tie to each other, in the order of their first ones. Numbers of a group keep
/// their order.
template <int Dim>
std::vector<std::vector<std::size_t>> tied_updates(const std::deque<SubmapUpdate<Dim>>& updates,
                                                   const std::vector<std::size_t>& waiting, const NamedEstimate<Dim>& estimate);

}  // namespace mapjoin
