// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Matching of sightings with known features: joint compatibility (Neira and Tardós, 2001), or nearest neighbours.

#include <cstdint>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

enum class AssociationMethod : std::uint8_t {
  kJcbb,     ///< Joint compatibility: whole sets of sightings at once, set aside if two answers are likely.
  kNearest,  ///< Each sighting by itself with the nearest feature within its gate, as the authors of I-SLSJF do; for
             ///< comparison.
};

constexpr auto enum_names(AssociationMethod) {
  return std::to_array<EnumName<AssociationMethod>>({{AssociationMethod::kJcbb, "jcbb"}, {AssociationMethod::kNearest, "nn"}});
}

/// The match of a sighting with a known feature.
struct Match {
  std::optional<std::size_t> known;  ///< The feature that fits best; nullopt if none was within the gates or left.
  double probability = 0.0;          ///< Probability that the sighting is of `known`.
  double squared_distance = 0.0;     ///< Squared Mahalanobis distance of the sighting alone.
  std::size_t candidates = 0;        ///< Number of known features within its gate.
  double score = 0.0;                ///< Log odds of the whole hypothesis (see Matcher::log_odds()); 0 with kNearest.
  /// Probability of the hypothesis against the placements that contradict this match; a factor of `probability`. 1 with
  /// kNearest.
  double placement_probability = 0.0;
};

/// Solves matching problems. All true pairings among `decisions` are within the gates with probability `confidence`; with
/// kNearest, each one.
template <int Dim>
class Matcher {
 public:
  Matcher(const NeighbourDensity<Dim>& density, AssociationMethod method, double confidence, double decisions);

  /// A match for every sighting, in their order.
  ///
  /// The hypothesis of the highest score is sought from sighting to sighting, following the most promising branches (beam
  /// search). Hypotheses of lower score follow that share none of its pairings and explain at least half as many sightings:
  /// other placements of the sightings. Shifts by which their map falls onto itself, as in a regular plantation, count as
  /// placements, too. Placements are compared by how well they fit and by their log odds, whichever is worse for the first. The
  /// probability of a pairing is a product: that of its hypothesis against the placements that contradict it, that of the
  /// hypothesis not being found by chance, and that of the pairing, given the others, against a feature not known yet.
  std::vector<Match> operator()(PairingProblem<Dim> problem);

  /// The placements to compare, the best first. Removes choices that are outside of the gates by themselves from the problem,
  /// which must outlive the placements.
  std::vector<Hypothesis<Dim>> placements(PairingProblem<Dim>& problem);
  /// The match of each pairing of a placement that is right but for shifts by which the sightings' map falls onto itself: its
  /// probability, given the others, against a feature not known yet.
  std::vector<Match> matches(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement);
  /// The logarithm of the odds of a placement against features that all are others: its score, less what the maps then
  /// overlooked of each other.
  double log_odds(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement);

  double gate() { return gates_(Dim); }

 private:
  std::vector<std::size_t> gated(PairingProblem<Dim>& problem);
  std::vector<Hypothesis<Dim>> placements(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order);
  double squared_distance(const PairingProblem<Dim>& problem, const Pairing& pairing);
  bool contradicts(const Hypothesis<Dim>& other, const Pairing& pairing);
  double odds_of_shifts(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement, double tolerance2) const;
  void match_jointly(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order, std::vector<Match>& matches);
  void match_nearest(const PairingProblem<Dim>& problem, std::vector<Match>& matches);

  const NeighbourDensity<Dim>& density_;
  AssociationMethod method_;
  ChiSquaredQuantiles gates_;
};

}  // namespace mapjoin
