// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps one by one as they become known, with the estimate of all kept at its optimum.
//
// A new map is placed by the poses and features that it shares with the estimate. Only the part of the elimination tree that it
// touches is eliminated again (FrontTree), and only maps whose variables have moved are linearised again. A map that would
// hardly move known variables moves only new ones, until several of them together would move more (IncrementalEstimate). If
// chi2 has grown by more than the new map can explain, all maps so far are joined by join(), once, and the better estimate is
// taken.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <mapjoin/join/incremental/driven_segments.hpp>
#include <mapjoin/join/incremental/named_estimate.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/join/join.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The effect of adding an update.
struct AddedUpdate {
  /// True if it is in the estimate. An update that shares too little with it waits until something ties it. One that is tied
  /// may still leave some of its poses and features free to move, its information being singular: these stay where they were
  /// placed, without a covariance, until other updates determine them. Only the first updates wait for that, too.
  bool is_joined = false;
  double metres = 0.0;         ///< Largest move of a position that was known before (m).
  double radians = 0.0;        ///< Largest rotation of a pose that was known before (rad).
  double chi2 = 0.0;           ///< chi2 of all joined updates at the estimate.
  std::int64_t dof = 0;        ///< Degrees of freedom of `chi2`; negative if more is free to move than is measured twice.
  std::size_t eliminated = 0;  ///< Variables eliminated again, over all iterations.
  int iterations = 0;
  bool converged = true;       ///< True if the estimate converged when it was settled last.
  bool batch_checked = false;  ///< True if all updates were joined by join(), too.
  bool batch_adopted = false;  ///< True if that estimate was taken, as the better or the only one.
};

/// An incremental join. It can be moved; one that was moved from can only be assigned to or destroyed.
template <int Dim>
class IncrementalJoin {
 public:
  /// `origin` is the anchor of the first pose of the first update in the estimate if neither priors nor fixed poses place the
  /// map; if an earlier update is tied later, all moves so that its first pose is there. std::invalid_argument if `origin` is
  /// no pose.
  explicit IncrementalJoin(const Pose<Dim>& origin = {});

  /// Adds the next update. Its segment begins with a new pose or with the last one of an earlier segment that no other
  /// continues, and its other poses are new; all other poses that it concerns are of earlier segments. One without a source is
  /// called by its number among all updates, "update 3". Bad input, and nothing is added, if that is not so or check_update()
  /// finds a fault. If a stop is requested while all updates are joined at once, the estimate stays as it is, and an update
  /// that needs that join waits.
  Expected<AddedUpdate> add(SubmapUpdate<Dim> update, const std::stop_token& stop = {});

  /// Adds many updates at once, such as the first part of a long log that is there already. The result is that of all together;
  /// if one is bad input, those before it wait.
  Expected<AddedUpdate> add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop = {});
  /// Bad input where add() would find it.
  Expected<void> check(const SubmapUpdate<Dim>& update) const;
  /// Bad input if add() would find it with these updates added one after the other.
  Expected<void> check(std::span<const SubmapUpdate<Dim>> updates) const;

  /// Lets the local map of an update keep more poses, which closures, priors and observations that come late can then concern:
  /// `map`, an update of a local map alone, of the same observations, takes its place. Updates count from 0 as they were added.
  /// Bad input, and nothing is changed, unless `map` has all poses and features of the former one, the same first and last
  /// pose, and new poses that are in no segment. std::out_of_range if there is no update of this number.
  Expected<AddedUpdate> keep_more(std::size_t number, const SubmapUpdate<Dim>& map, const std::stop_token& stop = {});
  /// Adds an update of closures, without a segment, features, priors and fixed poses, but leaves it out. Returns its number.
  /// Bad input as add(), and for any other update.
  Expected<std::size_t> hold(SubmapUpdate<Dim> update);
  /// Takes updates out, by their numbers, as if they had never been joined, and joins others that were left out; all must be
  /// such as hold() adds. An update that was in the estimate may have bent it too far for steps to lead back: the others are
  /// then joined by join(), too, once. If they are tied in parts only, the first part that can be joined stays, and the updates
  /// of the others wait. std::invalid_argument if a number is not that of such an update.
  AddedUpdate change(std::span<const std::size_t> out, std::span<const std::size_t> in, const std::stop_token& stop = {});

  /// Joins all updates in the estimate by join(), and takes the result if its chi2 is less.
  AddedUpdate rejoin(const std::stop_token& stop = {});

  /// The estimate after the last change that has returned; empty before. Any thread may call this at any time, without waiting
  /// for an update, and ask the snapshot while this object goes on or is gone. All other members belong to one thread.
  std::shared_ptr<const JoinedSnapshot<Dim>> snapshot() const;
  /// The estimate of a pose or feature; null if it is not in it.
  const Pose<Dim>* pose(const PoseId& id) const { return estimate_.pose(id); }
  const Point<Dim>* feature(const FeatureId& id) const { return estimate_.feature(id); }
  /// The marginal covariance of the step of a pose or feature, relative to the gauge as in GlobalMap: zero if it is anchored,
  /// nullopt if it is not in the estimate or may be free to move. It costs as much as the fronts between it and the root. It is
  /// that of the present estimate: the information of deferred maps on variables that were known before does not count yet.
  /// Residuals err by less than 0.5 % of a standard deviation (rms, if maps fit as their covariances say), but Jacobians of a
  /// pose in space may be older than a turn of less than 1 rad, until the next map that concerns it.
  std::optional<PoseMatrix<Dim>> covariance(const PoseId& id) const { return snapshot()->covariance(id); }
  std::optional<PointMatrix<Dim>> covariance(const FeatureId& id) const { return snapshot()->covariance(id); }
  double chi2() const { return estimate_.chi2(); }
  std::int64_t dof() const { return estimate_.dof(); }
  std::size_t waiting() const { return waiting_.size(); }
  std::size_t update_count() const { return updates_.size(); }
  const SubmapUpdate<Dim>& update(std::size_t number) const { return updates_[number]; }
  /// The numbers of the updates that were left out, or taken out.
  const std::set<std::size_t>& left_out() const { return left_out_; }
  bool is_waiting(std::size_t number) const { return std::ranges::binary_search(waiting_, number); }

 private:
  /// The last snapshot, for other threads.
  struct Published {
    std::mutex mutex;
    std::shared_ptr<const JoinedSnapshot<Dim>> snapshot = std::make_shared<const JoinedSnapshot<Dim>>();
  };

  /// Shows the estimate to other threads; returns `added` with the figures of the estimate.
  AddedUpdate published(AddedUpdate added);
  /// Checks an update and adds it behind the others.
  Expected<void> accept(SubmapUpdate<Dim> update);
  void join_last(const std::stop_token& stop, AddedUpdate& added);
  void join_again_from(std::size_t before, const std::stop_token& stop, AddedUpdate& added);
  bool asks_for_join(const SubmapUpdate<Dim>& update) const;
  void note(const Settling& settling, AddedUpdate& added);
  bool has_outgrown(double chi2_before, std::int64_t dof_before) const;
  /// The number of poses and features that the waiting updates share with the estimate.
  std::size_t shared_by_waiting() const;
  void admit_waiting(const std::stop_token& stop, AddedUpdate& added);
  /// Joins all updates in the estimate by join(), and takes the result if chi2 is less. If they are tied in parts only, as
  /// others were taken out, takes the first part that can be joined, and the updates of the others wait.
  void join_all(const std::stop_token& stop, AddedUpdate& added);
  /// Joins all updates in the estimate and these waiting ones by join(), and takes the result; if none wait, only if chi2 is
  /// less. True if it was taken.
  bool adopt_batch(const std::vector<std::size_t>& waiting, const std::stop_token& stop, AddedUpdate& added);
  /// Adopts the first of these groups of waiting updates that can be joined. True if there is one.
  bool adopt_first(const std::vector<std::vector<std::size_t>>& groups, const std::stop_token& stop, AddedUpdate& added);
  void take(const std::vector<const SubmapUpdate<Dim>*>& updates, const SubmapSet<Dim>& set, const Join<Dim>& joined,
            AddedUpdate& added);

  Pose<Dim> origin_;
  std::deque<SubmapUpdate<Dim>> updates_;
  DrivenSegments<Dim> driven_;
  std::vector<std::size_t> waiting_;   // updates that are not in the estimate, ascending
  std::set<std::size_t> left_out_;     // updates that may not be in it
  std::size_t shared_when_tried_ = 0;  // shared_by_waiting() when they were tried last
  NamedEstimate<Dim> estimate_;
  std::unique_ptr<Published> published_ = std::make_unique<Published>();
  bool is_anchored_by_world_ = false;
  bool is_converged_ = true;  // as of the last settling
};

}  // namespace mapjoin
