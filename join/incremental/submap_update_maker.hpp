// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The updates of a growing log: its new part is cut into segments, and every complete one becomes an update.

#include <map>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace mapjoin {

/// A local map that keeps more poses than before, as an update of its own.
template <int Dim>
struct RemadeMap {
  std::size_t update = 0;  ///< Number of the update whose map it is; they count from 0 as they were taken.
  SubmapUpdate<Dim> map;
};

/// Makes updates of a growing log. A segment is complete when the step after it has come, as its observations then have, too,
/// in a log that is written while the robot drives. A segment that sees no feature stays raw, as only closures to its poses can
/// tie it to others.
template <int Dim>
class SubmapUpdateMaker {
 public:
  /// `split` is by a number of poses, features or metres; kAuto is 10 poses, as its cost model needs the whole log.
  /// Throws std::invalid_argument if the options do not validate.
  explicit SubmapUpdateMaker(SplitOptions split, MinimiseOptions solver = {});

  /// Takes odometry, closures, feature observations and priors, with their losses; fixed poses are ignored. What concerns a
  /// pose that a local map has eliminated makes that map anew, with the pose (see take_remade()). False if a new pose has to
  /// be before those of updates, or such a map cannot be made: the log must then be cut anew, from its begin, by another maker.
  /// Throws std::invalid_argument if check_invariants() finds a fault.
  bool add(const Log<Dim>& news);
  /// The local maps that were made anew since the last call, to be put in the place of their former ones before updates are
  /// taken, which may concern their poses.
  std::vector<RemadeMap<Dim>> take_remade() { return std::exchange(remade_, {}); }
  /// The updates that are complete; at the end of the log all that is left. What comes late, of poses of updates, is in the
  /// first of them. Bad input if a pose cannot be named.
  Expected<std::vector<SubmapUpdate<Dim>>> take(bool is_end);

 private:
  struct Edge {
    PoseId base;
    PoseId target;
    PoseFactor<Dim> observation;
  };
  struct Observation {
    PoseId pose;
    FeatureId feature;
    FeatureFactor<Dim> observation;
  };
  struct PosePrior {
    PoseId pose;
    PoseFactor<Dim> prior;
  };
  struct FeaturePrior {
    FeatureId feature;
    FeatureFactor<Dim> prior;
  };
  /// The part of the log that is not in an update yet, as a log of its own, with its split.
  struct Window {
    Log<Dim> log;
    Split split;
    PoseIndex open_begin = 0;  // first of the poses that are not complete
  };

  /// True if the pose is in an update, and no further one begins with it.
  bool is_past(const PoseId& pose) const;
  /// Keeps these poses in the local maps that have eliminated them, which it makes anew. False if one cannot be made.
  bool keep(const std::set<PoseId>& poses);
  bool remake(std::size_t update);
  void note_maps(const Window& window);
  void hand_over_late_observations(std::vector<SubmapUpdate<Dim>>& updates);
  Expected<Window> window(bool is_end) const;
  /// Notes the window's poses up to the open ones.
  void note_poses(const Window& window);
  /// Hands closures and priors to the updates that make their poses and features known; at the end of the log all.
  void hand_over(std::vector<SubmapUpdate<Dim>>& updates, bool is_end);
  void hand_over_closures(std::vector<SubmapUpdate<Dim>>& updates);
  void hand_over_pose_priors(std::vector<SubmapUpdate<Dim>>& updates);
  void hand_over_feature_priors(std::vector<SubmapUpdate<Dim>>& updates, bool is_end);
  void forget(const Window& window);

  SplitOptions split_;
  MinimiseOptions solver_;
  std::vector<Edge> edges_;     // between poses that are not past
  std::vector<Edge> closures_;  // to poses that are past
  std::vector<Observation> observations_;
  std::vector<PosePrior> pose_priors_;  // that are in no update yet, as the next
  std::vector<FeaturePrior> feature_priors_;
  std::vector<Observation> late_observations_;                  // from poses that are past
  std::map<PoseId, std::optional<std::size_t>> eliminated_in_;  // for the poses of all updates; nullopt if kept
  std::map<std::size_t, Log<Dim>> segments_;                    // those of local maps, by the number of their update
  std::vector<RemadeMap<Dim>> remade_;
  std::size_t taken_ = 0;  // updates so far
  PoseId last_;
};

}  // namespace mapjoin
