// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Candidate alignments of one map with another: pairings of their features that are jointly compatible, whatever the relative
// pose.

#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Pairings around one feature, the relative pose that they imply, and their score.
template <int Dim>
struct AlignmentCandidate {
  std::vector<Pairing> pairs;
  Pose<Dim> second_in_first;
  double score = 0.0;  ///< The logarithm of the odds against maps that do not overlap.
};

/// Candidate alignments of a second map with a first one. The maps, the model and its references must outlive this.
template <int Dim>
class AlignmentCandidates {
 public:
  AlignmentCandidates(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model);

  /// The rigid motion that takes the second map's features onto those of the first; nullopt if the pairings do not determine
  /// it.
  std::optional<Pose<Dim>> relative_pose(const std::vector<Pairing>& pairs) const;
  /// The log odds, at most 0, that a feature at this point, unseen by the first map, adds to an alignment. It may be farther
  /// from the map's poses by the gate of its variance (m²).
  double unseen_by_first(const Point<Dim>& feature, double variance) const {
    return unseen(feature, variance, first_, first_poses_);
  }
  double unseen_by_second(const Point<Dim>& feature, double variance) const {
    return unseen(feature, variance, second_, second_poses_);
  }
  const PointTree<Dim>& first_tree() const { return first_tree_; }
  const PointTree<Dim>& second_tree() const { return second_tree_; }

  /// The alignment that a constellation leads to, its pairings extended from neighbour to neighbour; nullopt if the
  /// constellation itself is not compatible.
  std::optional<AlignmentCandidate<Dim>> grown_from(const Constellation& seed) const;
  /// True if most pairings of another candidate are compatible with those of the best one: both are then the same alignment.
  bool agree(const AlignmentCandidate<Dim>& best, const AlignmentCandidate<Dim>& other) const;

 private:
  /// Features of the first map (known) and of the second one (sightings), by index in their maps.
  using Features = KnownAndSightings;
  double unseen(const Point<Dim>& feature, double variance, const FeatureMap<Dim>& map, const PointTree<Dim>& poses) const;
  PairingProblem<Dim> problem(const Features& features, const Pose<Dim>& pose) const;
  double anywhere(const Extension<Dim>& extension) const;
  void extend(const PairingProblem<Dim>& problem, std::size_t sighting, Hypothesis<Dim>& hypothesis,
              ChiSquaredQuantiles& gates) const;
  double against(const PairingProblem<Dim>& problem, const Features& features, const Hypothesis<Dim>& hypothesis,
                 const Pose<Dim>& pose, ChiSquaredQuantiles& gates) const;
  ChiSquaredQuantiles gates_for(const Features& features) const {
    return ChiSquaredQuantiles((1.0 - model_.confidence) / static_cast<double>(features.known.size()));
  }

  const FeatureMap<Dim>& first_;
  const FeatureMap<Dim>& second_;
  const AlignmentModel<Dim>& model_;
  PointTree<Dim> first_tree_;
  PointTree<Dim> second_tree_;
  PointTree<Dim> first_poses_;
  PointTree<Dim> second_poses_;
  double gate_;
  double offset_variance_;  // prior variance of the second map's offset along an axis (m²)
};

}  // namespace mapjoin
