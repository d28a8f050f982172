// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The alignment of pairs of maps that could lie on each other in several ways, as in a regular plantation, all together.

#include <mapjoin/join/association/alignment_branch.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Aligns pairs of maps one after the other, the surest first, and follows every possible alignment as a branch (multiple
/// hypotheses): the alignment of one pair predicts those of the next, and how well these fit tells which alignment of the first
/// is right.
template <int Dim>
class JointAlignment {
 public:
  /// Of `pairs` of maps that `matching` found. The references must outlive this.
  JointAlignment(const FeatureEstimate<Dim>& estimate, const Identities& identities, const NeighbourDensity<Dim>& density,
                 const MapMatching<Dim>& matching, double confidence, std::vector<MapPair<Dim>> pairs);

  /// The pairings of the best branch that are probable, whichever branch is right.
  std::vector<Proposal> propose(const std::stop_token& stop);

 private:
  /// The features of the earlier map (known) and of the later one (sightings) of a pair that the other map does not see.
  struct Features {
    std::vector<FeatureIndex> known;
    std::vector<FeatureIndex> sightings;
  };
  using Branch = AlignmentBranch<Dim>;
  /// A pair of maps, by its index, given what the best branch holds.
  struct Rated {
    std::size_t pair = 0;
    double confusable = 0.0;  // number of other features that one may be mistaken for
    Point<Dim> moved;         // expected change of the difference of their features (m)
  };

  Features features_of(const MapPair<Dim>& pair) const;
  std::vector<Rated> rated();
  std::optional<std::size_t> next();
  std::size_t overlap_where(const MapPair<Dim>& pair, const Point<Dim>& moved) const;
  void place(std::size_t pair);
  PairingProblem<Dim> problem(const Branch& branch, const Features& features) const;
  std::vector<Branch> placed(const Branch& branch, std::size_t pair, const Features& features) const;
  void prune(std::vector<Branch> branches);
  bool is_sure() const;
  double share_of(const AlignedPair& placed) const;

  const FeatureEstimate<Dim>& estimate_;
  const Identities& identities_;
  const MapMatching<Dim>& matching_;
  double confidence_;
  double per_deviation_;  // NeighbourDensity::confusable_per_deviation()
  double gate_;
  std::vector<MapPair<Dim>> pairs_;
  std::vector<bool> is_tried_;  // by pair
  CovarianceColumns<Dim> covariances_;
  std::vector<Branch> branches_;   // the best first
  std::vector<FeaturePair> held_;  // the pairings that coupling_ was computed for
  Eigen::MatrixXd coupling_;       // AlignmentBranch::coupling() of all pairs of maps with held_
};

}  // namespace mapjoin
