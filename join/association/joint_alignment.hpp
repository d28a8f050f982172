// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pairs of maps that could lie on each other in several ways, as in a regular plantation, placed all together.

#include <mapjoin/join/association/alignment_branch.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Places pairs of maps one after the other, the surest first, and follows every way in which they may lie as a branch
/// (multiple hypotheses): where one pair lies tells where the next ones do, and which of them fit tells where the first one
/// lies.
template <int Dim>
class JointAlignment {
 public:
  /// All but `pairs` must stay.
  JointAlignment(const FeatureEstimate<Dim>& estimate, const Identities& identities, const NeighbourDensity<Dim>& density,
                 double confidence, std::vector<MapPair<Dim>> pairs);

  /// The pairings that are probable, whichever branch is right.
  std::vector<Proposal> propose(const std::stop_token& stop);

 private:
  /// A pair of maps, and the features of either that the other one does not have.
  struct Features {
    std::vector<FeatureIndex> known;
    std::vector<FeatureIndex> sightings;
  };
  using Branch = AlignmentBranch<Dim>;
  /// A pair of maps, by its index, as a branch has it.
  struct Rated {
    std::size_t pair = 0;
    double confusable = 0.0;  // features that one may be mistaken for
    Point<Dim> moved;         // that the difference of their features is expected to change
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
  Matcher<Dim> matcher() const;
  double log_tests() const;

  const FeatureEstimate<Dim>& estimate_;
  const Identities& identities_;
  const NeighbourDensity<Dim>& density_;
  double confidence_;
  double per_deviation_;  // features that one may be mistaken for, by the square root of a determinant
  double gate_;
  std::vector<MapPair<Dim>> pairs_;
  std::vector<bool> is_tried_;  // by pair
  CovarianceColumns<Dim> covariances_;
  std::vector<Branch> branches_;   // the best first
  std::vector<FeaturePair> held_;  // what coupling_ was computed for
  Eigen::MatrixXd coupling_;       // of all pairs, to what the best branch holds
};

}  // namespace mapjoin
