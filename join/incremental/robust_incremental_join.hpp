// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining local maps one by one where closures may be wrong: such are left out, and taken out again where they were believed.
//
// A closure that comes is judged by its Mahalanobis distance from what the estimate predicts, with the covariance that the
// fronts give: what is too far off is left out. That is a doubt, for it may be right, and what was joined before wrong; so is a
// chi2 that grows more than a map can explain. Where there is doubt, find_inliers() judges all closures so far, by the
// agreement of any two of them and by maps of its own, and the estimate follows: what it rejects is taken out, what it keeps is
// joined. It is asked again once there are a quarter more updates, so that all its work is at most five times that of the last
// time.

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

/// What adding an update did, or judging all.
struct RobustlyAdded {
  AddedUpdate added = {};
  std::vector<ClosureName> rejected = {};    ///< Left out from now on: they are new, or have been taken out.
  std::vector<ClosureName> readmitted = {};  ///< Joined that were left out.
  bool is_judged = false;                    ///< Whether find_inliers() was asked;
  std::optional<Error> no_verdict = {};      ///< why that found none: all closures are then where they were.
};

/// Closures are pose factors between poses that are not successive ones of the update's segment, and such as repeat odometry.
/// All else is believed, and so is a closure that ties what nothing else does, until more is known.
template <int Dim>
class RobustIncrementalJoin {
 public:
  /// `options.odometry` is passed over. The origin is that of IncrementalJoin. Throws as that does.
  explicit RobustIncrementalJoin(const RobustOptions& options = {}, const Pose<Dim>& origin = {});

  /// Adds an update as IncrementalJoin does, but for closures that are held to be wrong.
  Expected<RobustlyAdded> add(SubmapUpdate<Dim> update, const std::stop_token& stop = {});
  /// Adds many at once, and judges all closures. Of bad input nothing is added.
  Expected<RobustlyAdded> add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop = {});
  /// Has find_inliers() judge all closures, whatever the doubt, and joins all by join(), too. At the end of a log whose
  /// segments are raw, what is left out is what find_inliers() rejects of it, and the estimate is that of the rest.
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
  /// Whether the estimate, which knows its ends, says that the closure cannot be right.
  bool contradicts(const SubmapUpdate<Dim>& closure) const;
  /// Joins closures of which the estimate does not know an end, and leaves out the others. Gives the numbers of these.
  Expected<std::vector<std::size_t>> hold(std::vector<SubmapUpdate<Dim>> closures, const std::stop_token& stop,
                                          RobustlyAdded& done);
  /// How much chi2 a closure, or some of as many rows, may have and still be right.
  double gate(double dof) const;
  /// Joins closures that are left out, and takes them out again where they do not fit.
  void try_closures(std::span<const std::size_t> closures, const std::stop_token& stop, RobustlyAdded& done);
  bool is_due() const;
  void take_verdict(const std::stop_token& stop, RobustlyAdded& done);
  ClosureName name(std::size_t closure) const;
  /// What became of closures since these were left out.
  void compare_with(const std::set<std::size_t>& left_out_before, RobustlyAdded& done) const;

  RobustOptions options_;
  IncrementalJoin<Dim> join_;
  std::vector<std::size_t> closures_;  // their numbers among the updates of join_, ascending
  std::size_t added_ = 0;              // updates
  bool is_doubtful_ = false;
  std::size_t judged_at_ = 0;  // so many updates of join_
};

}  // namespace mapjoin
