// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps one by one as they become known, with the estimate of all kept at its optimum.
//
// A new map is placed by what it shares with the estimate. Of the elimination tree only what it touches is done again
// (FrontTree), and only maps whose variables have moved are linearised again. A map that would move hardly anything else moves
// only what is new, until several of them would move more (IncrementalEstimate). Where the chi2 has grown more than the new map
// can explain, all maps so far are joined by join(), once, and the better estimate is taken.

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

/// What adding an update did.
struct AddedUpdate {
  /// Whether it is in the estimate. An update that shares too little with it waits until something ties it.
  bool is_joined = false;
  double metres = 0.0;         ///< The most that a position has moved that was known before (m),
  double radians = 0.0;        ///< and a pose has turned (rad).
  double chi2 = 0.0;           ///< Of all joined updates at the estimate,
  std::int64_t dof = 0;        ///< and its degrees of freedom.
  std::size_t eliminated = 0;  ///< Variables eliminated again, over all iterations.
  int iterations = 0;
  bool converged = true;       ///< As the estimate was settled last.
  bool batch_checked = false;  ///< Whether all updates were joined by join(), too,
  bool batch_adopted = false;  ///< and its estimate was taken, for it was better or the only one.
};

/// Can be moved; what was moved from can only be assigned to or destroyed.
template <int Dim>
class IncrementalJoin {
 public:
  /// Where the first pose of the first update in the estimate is anchored when the World says nothing; should an earlier update
  /// be tied later, all moves so that its first pose is. std::invalid_argument where that is no pose.
  explicit IncrementalJoin(const Pose<Dim>& origin = {});

  /// Adds the next update. Its segment begins with a new pose or with the last one of an earlier segment that none goes on from
  /// yet, and its other poses are new; all else that it concerns is of earlier segments. Bad input where that is not so or
  /// check_update() finds a fault: nothing is added. Where a stop is requested while all updates are joined at once, the
  /// estimate stays as it is, and an update that took that waits.
  Expected<AddedUpdate> add(SubmapUpdate<Dim> update, const std::stop_token& stop = {});

  /// Adds many at once, as where the first part of a long log is there already. What is said of one holds for all of them; of
  /// bad input, those before it wait.
  Expected<AddedUpdate> add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop = {});
  /// Bad input where add() would find it.
  Expected<void> check(const SubmapUpdate<Dim>& update) const;
  /// The same, were these added one after the other.
  Expected<void> check(std::span<const SubmapUpdate<Dim>> updates) const;

  /// Adds an update of closures, without a segment, features and fixed poses, but leaves it out. Gives its number: updates
  /// count from 0 as they were added. Bad input as of add().
  Expected<std::size_t> hold(SubmapUpdate<Dim> update);
  /// Takes updates that hold() could take out, by their numbers, as if they had never been joined, and joins others that were
  /// left out. Where one that goes was in the estimate it may have bent this too far for steps to lead back: all others are
  /// then joined by join(), too, once. std::invalid_argument where one of these is not there or is none of closures alone.
  AddedUpdate change(std::span<const std::size_t> out, std::span<const std::size_t> in, const std::stop_token& stop = {});

  /// Joins all updates in the estimate by join(), and takes what comes of it where chi2 is less.
  AddedUpdate rejoin(const std::stop_token& stop = {});

  /// The estimate after the last of these that has returned, empty before. Any thread may call this at any time, and
  /// ask the snapshot while this object goes on or is gone: it waits for no update. All else here belongs to one thread.
  std::shared_ptr<const JoinedSnapshot<Dim>> snapshot() const;
  /// The estimate of a pose or feature, or null while it is not in it.
  const Pose<Dim>* pose(const PoseId& id) const { return estimate_.pose(id); }
  const Point<Dim>* feature(const FeatureId& id) const { return estimate_.feature(id); }
  /// The marginal covariance of its step, relative to the gauge as in GlobalMap: zero where it is anchored, nothing while it is
  /// not in the estimate or may be free to move. At the cost of the fronts between it and the root. It is that of the estimate
  /// as it stands: what a deferred map tells of what was known before does not count yet. Residuals err by less than 0.5 % of
  /// a standard deviation (rms, where maps fit as their covariances say), but Jacobians may be older than a turn of less than
  /// 1 rad of a pose in space, until the next map that concerns it.
  std::optional<PoseMatrix<Dim>> covariance(const PoseId& id) const;
  std::optional<PointMatrix<Dim>> covariance(const FeatureId& id) const;
  double chi2() const { return estimate_.chi2(); }
  std::int64_t dof() const { return estimate_.dof(); }
  std::size_t waiting() const { return waiting_.size(); }
  std::size_t update_count() const { return updates_.size(); }
  const SubmapUpdate<Dim>& update(std::size_t number) const { return updates_[number]; }
  /// The numbers of those that were left out, or taken out.
  const std::set<std::size_t>& left_out() const { return left_out_; }
  bool is_waiting(std::size_t number) const { return std::ranges::binary_search(waiting_, number); }

 private:
  /// Where other threads find the last snapshot.
  struct Published {
    std::mutex mutex;
    std::shared_ptr<const JoinedSnapshot<Dim>> snapshot = std::make_shared<const JoinedSnapshot<Dim>>();
  };

  /// Shows the estimate to other threads; gives what was done, with how good the estimate is.
  AddedUpdate published(AddedUpdate added);
  /// Puts a sound update behind the others.
  Expected<void> accept(SubmapUpdate<Dim> update);
  void join_last(const std::stop_token& stop, AddedUpdate& added);
  void join_again_from(std::size_t before, const std::stop_token& stop, AddedUpdate& added);
  bool asks_for_join(const SubmapUpdate<Dim>& update) const;
  void settle(std::span<const JoinedIndex> last, AddedUpdate& added);
  void note(const Settling& settling, AddedUpdate& added);
  bool has_outgrown(double chi2_before, std::int64_t dof_before) const;
  /// How many of their poses and features the waiting updates share with the estimate.
  std::size_t shared_by_waiting() const;
  void admit_waiting(const std::stop_token& stop, AddedUpdate& added);
  /// Joins all updates in the estimate and these waiting ones by join(), and takes what comes of it: where none wait only if
  /// chi2 is less. Whether it was taken.
  bool adopt_batch(const std::vector<std::size_t>& waiting, const std::stop_token& stop, AddedUpdate& added);
  /// With the first group of tied_updates() that can be joined.
  void adopt_tied(const std::stop_token& stop, AddedUpdate& added);
  void take(const std::vector<const SubmapUpdate<Dim>*>& updates, const SubmapSet<Dim>& set, const Join<Dim>& joined,
            AddedUpdate& added);

  Pose<Dim> origin_;
  std::deque<SubmapUpdate<Dim>> updates_;
  DrivenSegments<Dim> driven_;
  std::vector<std::size_t> waiting_;   // updates that are not in the estimate, ascending
  std::set<std::size_t> left_out_;     // updates that may not be in it
  std::size_t shared_when_tried_ = 0;  // by those that were waiting then
  NamedEstimate<Dim> estimate_;
  std::unique_ptr<Published> published_ = std::make_unique<Published>();
  bool is_anchored_by_world_ = false;
  bool is_converged_ = true;  // as it was settled last
};

}  // namespace mapjoin
