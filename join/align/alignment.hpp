// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The alignment of a partial map in the frame of another, from the poses and features they share and the closures between them.

#include <limits>
#include <mapjoin/join/align/partial_map.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {

/// The rigid motion that takes `from` onto `to`, of equal number, with the least sum of squared distances (align()); nullopt if
/// the points do not determine it: fewer than two distinct ones in 2D, all on a line in 3D.
template <int Dim>
std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// As rigid_alignment(); where points on a line in space leave the roll about it free, of all such motions the one that turns
/// the least.
template <int Dim>
std::optional<Pose<Dim>> least_turning_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// The rigid motion that takes more than half of `from` near `to`, of equal number and at least one: that of the least median
/// squared distance among those by random pairs, triples in space; nullopt if none of these determines a motion.
template <int Dim>
std::optional<Pose<Dim>> least_median_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// Poses and points that two frames have in common.
template <int Dim>
struct Correspondences {
  std::vector<Pose<Dim>> alignments;     ///< Poses of the second frame in the first, each from one shared pose or closure.
  std::vector<Point<Dim>> first_points;  ///< Shared points in the first frame; second_points are the same in the second.
  std::vector<Point<Dim>> second_points;
  std::vector<Pose<Dim>> turns;  ///< As alignments, from closures that leave the position free: right in their rotation only.

  void add_pose(const Pose<Dim>& in_first, const Pose<Dim>& in_second);
  /// Adds the target of a closure; only its position counts if the closure does not measure rotation, as between robots, and
  /// only its rotation, for want of all else, if it does not measure position.
  void add_closure(const PoseFactor<Dim>& closure, const Pose<Dim>& in_first, const Pose<Dim>& in_second);
  void add_point(const Point<Dim>& in_first, const Point<Dim>& in_second);
  /// The alignments worth trying, those from poses first; empty if the correspondences do not determine any.
  std::vector<Pose<Dim>> candidates() const;
};

/// The candidate of least cost(candidate), the first of equals; the cost of a single one is not computed.
template <int Dim, typename Cost>
Pose<Dim> cheapest_alignment(const std::vector<Pose<Dim>>& candidates, Cost&& cost) {
  Pose<Dim> best = candidates.front();
  if (candidates.size() == 1) return best;
  double least = std::numeric_limits<double>::infinity();
  for (const Pose<Dim>& candidate : candidates) {
    const double of_candidate = cost(candidate);
    if (!(of_candidate < least)) continue;
    least = of_candidate;
    best = candidate;
  }
  return best;
}

/// The correspondences between two partial maps; `closures` may include others.
template <int Dim>
Correspondences<Dim> correspondences_between(const PartialMap<Dim>& a, const PartialMap<Dim>& b,
                                             const std::vector<const PoseFactor<Dim>*>& closures);

/// The union of two partial maps in the frame of `a`, `b` placed by `alignment`; poses and features of both keep their values
/// in `a`.
template <int Dim>
PartialMap<Dim> merged(const PartialMap<Dim>& a, const PartialMap<Dim>& b, const Pose<Dim>& alignment);

/// Merges partial maps that share poses, features or closures until no two do, from neighbour to neighbour in the graph of
/// submaps, each in the frame of the first. The alignment of least chi2 is chosen among several or, without `tries_hypotheses`,
/// the first. Neighbours that share nothing with any other are merged at once.
template <int Dim>
std::vector<PartialMap<Dim>> merge_tied(std::vector<PartialMap<Dim>> partials,
                                        const std::vector<const PoseFactor<Dim>*>& closures, bool tries_hypotheses);

}  // namespace mapjoin
