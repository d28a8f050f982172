// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How one map may lie on another: pairings of their features that are compatible together, whatever the relative
// pose.

#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/join/association/point_tree.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// Pairings around one feature, and what they say.
template <int Dim>
struct AlignmentCandidate {
  std::vector<Pairing> pairs;
  Pose<Dim> second_in_first;
  double score = 0.0;  ///< The logarithm of the odds against maps that do not overlap.
};

/// The ways in which a second map may lie on a first one. The maps and what the model refers to must stay.
template <int Dim>
class AlignmentCandidates {
 public:
  AlignmentCandidates(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model);

  /// The rigid motion that takes the second map's features onto those of the first; nothing where it is not determined.
  std::optional<Pose<Dim>> relative_pose(const std::vector<Pairing>& pairs) const;
  /// What it says against an alignment that a map did not see a feature at a point, with a variance (m²): a logarithm of odds.
  /// It may be as much farther from the map's poses as is not known of where it is.
  double unseen_by_first(const Point<Dim>& feature, double variance) const {
    return unseen(feature, variance, first_, first_poses_);
  }
  double unseen_by_second(const Point<Dim>& feature, double variance) const {
    return unseen(feature, variance, second_, second_poses_);
  }
  const PointTree<Dim>& first_tree() const { return first_tree_; }
  const PointTree<Dim>& second_tree() const { return second_tree_; }

  /// The alignment that a constellation leads to, its pairings extended from neighbour to neighbour; nothing where the
  /// constellation itself is not compatible.
  std::optional<AlignmentCandidate<Dim>> grown_from(const Constellation& seed) const;
  /// Whether most pairings of another alignment are compatible with those of the best one: then it is the same.
  bool agree(const AlignmentCandidate<Dim>& best, const AlignmentCandidate<Dim>& other) const;

 private:
  /// Features of the first map and of the second one, by index in their maps; the latter's are the sightings.
  struct Features {
    std::vector<std::size_t> known;
    std::vector<std::size_t> sightings;
  };
  double unseen(const Point<Dim>& feature, double variance, const FeatureMap<Dim>& map, const PointTree<Dim>& poses) const;
  PairingProblem<Dim> problem(const Features& features, const Pose<Dim>& pose) const;
  double anywhere(const Extension<Dim>& extension) const;
  void extend(const PairingProblem<Dim>& problem, std::size_t sighting, Hypothesis<Dim>& hypothesis,
              ChiSquaredQuantiles& gates) const;
  double against(const PairingProblem<Dim>& problem, const Features& features, const Hypothesis<Dim>& hypothesis,
                 const Pose<Dim>& pose, ChiSquaredQuantiles& gates) const;
  ChiSquaredQuantiles gates_for(const Features& features) const {
    return ChiSquaredQuantiles(1.0 - (1.0 - model_.confidence) / static_cast<double>(features.known.size()));
  }

  const FeatureMap<Dim>& first_;
  const FeatureMap<Dim>& second_;
  const AlignmentModel<Dim>& model_;
  PointTree<Dim> first_tree_;
  PointTree<Dim> second_tree_;
  PointTree<Dim> first_poses_;
  PointTree<Dim> second_poses_;
  double gate_;
  double offset_variance_;  // along an axis, of where the second map may lie (m²)
};

}  // namespace mapjoin
