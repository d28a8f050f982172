// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps one by one with closures that may be wrong: these are left out, or taken out again if they were joined.
//
// A new closure is gated by its Mahalanobis distance from the prediction of the estimate, with the covariance that the fronts
// give; one that is too far off is left out. That raises doubt, for it may be right and closures joined before wrong; so does a
// chi2 that grows by more than a map can explain. In doubt find_inliers() judges all closures so far, by the agreement of any
// two of them and by maps of its own, and the estimate follows: closures that it rejects are taken out, those that it keeps are
// joined. It is asked again once there are a quarter more updates, so that all its work is at most five times that of the last
// time; at the next update if a stop was requested meanwhile. Doubt lasts until there is a verdict.

#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// A closure by the names of its ends.
struct ClosureName {
  PoseId base;
  PoseId target;
  auto operator<=>(const ClosureName&) const = default;
};

/// The effect of adding an update, or of judging all closures.
struct RobustlyAdded {
  AddedUpdate added = {};
  std::vector<ClosureName> rejected = {};    ///< Closures left out from now on: new ones, or ones taken out.
  std::vector<ClosureName> readmitted = {};  ///< Closures joined that were left out.
  bool is_judged = false;                    ///< True if find_inliers() was asked.
  std::optional<Error> no_verdict = {};      ///< Error of find_inliers(), which leaves all closures where they were.
};

/// An incremental join that is robust to wrong closures. Closures are pose factors between poses that are not successive ones
/// of the update's segment, and those that repeat odometry. All else is believed, and so is a closure with an end that the
/// estimate does not know, until more is known.
template <int Dim>
class RobustIncrementalJoin {
 public:
  /// `options.odometry` is ignored. `origin` is that of IncrementalJoin. std::invalid_argument if the options do not validate
  /// or `origin` is no pose.
  explicit RobustIncrementalJoin(const RobustOptions& options = {}, const Pose<Dim>& origin = {});

  /// Adds an update as IncrementalJoin::add() does, except for closures that are judged wrong. One without a source is called
  /// by its number among all updates that were added, "update 3".
  Expected<RobustlyAdded> add(SubmapUpdate<Dim> update, const std::stop_token& stop = {});
  /// Adds many updates at once, and judges all closures. Bad input as IncrementalJoin::add_all(), but nothing is then added.
  Expected<RobustlyAdded> add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop = {});
  /// Lets the local map of an update keep more poses, as IncrementalJoin::keep_more() does; updates count as they were added
  /// here.
  Expected<RobustlyAdded> keep_more(std::size_t number, const SubmapUpdate<Dim>& map, const std::stop_token& stop = {});
  /// Lets find_inliers() judge all closures, even without doubt, and joins all by join(), too. At the end of a log of raw
  /// segments the closures that are left out are those that find_inliers() rejects, and the estimate is that of the rest.
  RobustlyAdded judge(const std::stop_token& stop = {});

  const IncrementalJoin<Dim>& estimate() const { return join_; }
  /// The closures that are left out, in the order in which they came.
  std::vector<ClosureName> left_out() const;

 private:
  /// An update without its closures, and these as updates of their own.
  struct Apart {
    SubmapUpdate<Dim> update;
    std::vector<SubmapUpdate<Dim>> closures;
  };
  Apart apart(SubmapUpdate<Dim> update);
  bool knows_ends(const SubmapUpdate<Dim>& closure) const;
  /// True if a closure fails the gate of the estimate, which knows its ends.
  bool contradicts(const SubmapUpdate<Dim>& closure) const;
  /// Joins closures with an end that the estimate does not know, and leaves out the others, whose numbers it returns.
  Expected<std::vector<std::size_t>> hold(std::vector<SubmapUpdate<Dim>> closures, const std::stop_token& stop,
                                          RobustlyAdded& done);
  /// The largest chi2 of `dof` degrees of freedom at which a closure, or several, may still be right.
  double gate(double dof) const;
  /// Joins closures that are left out, and takes them out again if they do not fit.
  void try_closures(std::span<const std::size_t> closures, const std::stop_token& stop, RobustlyAdded& done);
  bool is_due() const;
  void take_verdict(const std::stop_token& stop, RobustlyAdded& done);
  ClosureName name(std::size_t closure) const;
  /// Notes the closures that were rejected or readmitted since `left_out_before`.
  void compare_with(const std::set<std::size_t>& left_out_before, RobustlyAdded& done) const;

  RobustOptions options_;
  IncrementalJoin<Dim> join_;
  std::vector<std::size_t> closures_;  // their numbers among the updates of join_, ascending
  std::vector<std::size_t> added_;     // the numbers of the updates that were added, without their closures
  bool is_doubtful_ = false;
  std::size_t asked_at_ = 0;  // number of updates of join_ when find_inliers() was asked last, and not interrupted
};

}  // namespace mapjoin
