// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The estimate of an incremental join as it stood after one of its updates, for threads other than the one that adds.

#include <map>
#include <mapjoin/join/incremental/incremental_estimate.hpp>
#include <mapjoin/model/ids.hpp>
#include <memory>
#include <mutex>
#include <optional>

namespace mapjoin {

/// The variables of poses and features by name. One thread enters names, and may look at its own entries; others find them.
class JoinedNames {
 public:
  void enter(const PoseId& id, JoinedIndex v) { enter(poses_, id, v); }
  void enter(const FeatureId& id, JoinedIndex v) { enter(features_, id, v); }
  std::optional<JoinedIndex> find(const PoseId& id) const { return find(poses_, id); }
  std::optional<JoinedIndex> find(const FeatureId& id) const { return find(features_, id); }
  /// The names of poses, and of features, for the thread that enters them.
  const std::map<PoseId, JoinedIndex>& poses() const { return poses_; }
  const std::map<FeatureId, JoinedIndex>& features() const { return features_; }

 private:
  template <typename Id>
  void enter(std::map<Id, JoinedIndex>& names, const Id& id, JoinedIndex v) {
    const std::lock_guard lock(mutex_);
    names[id] = v;
  }
  template <typename Id>
  std::optional<JoinedIndex> find(const std::map<Id, JoinedIndex>& names, const Id& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = names.find(id);
    return found == names.end() ? std::nullopt : std::optional(found->second);
  }

  mutable std::mutex mutex_;  // held for one look-up; readers of a shared one could keep the writer waiting
  std::map<PoseId, JoinedIndex> poses_;
  std::map<FeatureId, JoinedIndex> features_;
};

/// An estimate that never changes; later updates are in later snapshots. Any number of threads may ask it.
template <int Dim>
class JoinedSnapshot {
 public:
  JoinedSnapshot() = default;
  JoinedSnapshot(std::shared_ptr<const JoinedNames> names, KeptEstimate<Dim> estimate)
      : names_(std::move(names)), estimate_(std::move(estimate)) {}

  /// The estimate of a pose or feature; nullopt if it was not in it.
  std::optional<Pose<Dim>> pose(const PoseId& id) const;
  std::optional<Point<Dim>> feature(const FeatureId& id) const;
  /// The marginal covariance of the step of a pose or feature, as IncrementalJoin::covariance(), at the cost of the fronts
  /// between it and the root.
  std::optional<PoseMatrix<Dim>> covariance(const PoseId& id) const;
  std::optional<PointMatrix<Dim>> covariance(const FeatureId& id) const;
  /// The joint covariance of two different poses, the rows of the first before those of the second.
  std::optional<Matrix<2 * kPoseDof<Dim>>> covariance(const PoseId& first, const PoseId& second) const;
  double chi2() const { return estimate_.chi2; }
  std::int64_t dof() const { return estimate_.dof; }

 private:
  /// The variable of a name; nullopt if it was not known yet.
  template <typename Id>
  std::optional<JoinedIndex> find(const Id& id) const;
  template <typename Matrix, typename Id>
  std::optional<Matrix> covariance_of(const Id& id) const;

  std::shared_ptr<const JoinedNames> names_ = std::make_shared<const JoinedNames>();
  KeptEstimate<Dim> estimate_;
};

}  // namespace mapjoin
