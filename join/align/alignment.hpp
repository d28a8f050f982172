// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where a partial map stands in the frame of another: from the poses and features they share and the closures between them.

#include <limits>
#include <mapjoin/join/align/partial_map.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {

/// The rigid motion that takes `from` onto `to`, of equal number, with the least sum of squared distances (align()), or nothing
/// where the points do not determine it: fewer than two distinct ones in 2D, all on a line in 3D.
template <int Dim>
std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to);

/// What ties two frames together.
template <int Dim>
struct Correspondences {
  std::vector<Pose<Dim>> alignments;     ///< Of the second frame in the first, each from one shared pose or closure.
  std::vector<Point<Dim>> first_points;  ///< The same points in both frames.
  std::vector<Point<Dim>> second_points;

  void add_pose(const Pose<Dim>& in_first, const Pose<Dim>& in_second);
  /// The target of a closure, which may be known by its position alone: as a robot that another one sees.
  void add_closure(const PoseFactor<Dim>& closure, const Pose<Dim>& in_first, const Pose<Dim>& in_second);
  void add_point(const Point<Dim>& in_first, const Point<Dim>& in_second);
  /// The alignments worth trying, those from poses first; empty where the ties do not determine one.
  std::vector<Pose<Dim>> candidates() const;
};

/// The candidate of least cost(candidate), the first of equals; a single one is not weighed.
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

/// The ties between two partial maps; `closures` may hold others, too.
template <int Dim>
Correspondences<Dim> correspondences_between(const PartialMap<Dim>& a, const PartialMap<Dim>& b,
                                             const std::vector<const PoseFactor<Dim>*>& closures);

/// Both partial maps in the frame of `a`, `b` placed by `alignment`; what both hold keeps its value in `a`.
template <int Dim>
PartialMap<Dim> merged(const PartialMap<Dim>& a, const PartialMap<Dim>& b, const Pose<Dim>& alignment);

/// Merges partial maps that are tied by poses, features or closures until none are, each in the frame of the first, from
/// neighbour to neighbour in the graph of submaps. Of several alignments the one of least chi2 is taken or, without
/// `tries_hypotheses`, the first. Neighbours that share nothing with any other are merged at once.
template <int Dim>
std::vector<PartialMap<Dim>> merge_tied(std::vector<PartialMap<Dim>> partials,
                                        const std::vector<const PoseFactor<Dim>*>& closures, bool tries_hypotheses);

}  // namespace mapjoin
