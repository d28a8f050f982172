// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which sightings are of which known features: joint compatibility (Neira and Tardós, 2001), or nearest neighbours.

#include <cstdint>
#include <mapjoin/join/association/hypothesis.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

enum class AssociationMethod : std::uint8_t {
  kJcbb,  ///< Joint compatibility, branch and bound: whole sets of sightings at once, set aside where two answers are likely.
  kNearest,  ///< Each sighting by itself with the nearest feature within its gate, as the authors of I-SLSJF do; for
             ///< comparison.
};

constexpr auto enum_names(AssociationMethod) {
  return std::to_array<EnumName<AssociationMethod>>({{AssociationMethod::kJcbb, "jcbb"}, {AssociationMethod::kNearest, "nn"}});
}

/// What matching made of a sighting.
struct Match {
  std::optional<std::size_t> known;  ///< The feature that fits best; nothing where none was in the gates or left.
  double probability = 0.0;          ///< That the sighting is of it.
  double squared_distance = 0.0;     ///< Mahalanobis, of the sighting alone.
  std::size_t candidates = 0;        ///< Known features within its gate.
  double score = 0.0;                ///< Of the whole hypothesis (see Hypothesis).
};

/// Matches of one problem after the other. With `confidence` a true pairing of one among `decisions` is within its gate.
template <int Dim>
class Matcher {
 public:
  Matcher(const NeighbourDensity<Dim>& density, AssociationMethod method, double confidence, double decisions);

  /// A match for every sighting, in their order.
  ///
  /// The hypothesis of the highest score is found by branch and bound over the sightings, of which the most promising branches
  /// are followed. Then those of the highest scores that share none of its pairings, as long as they explain half as many:
  /// other placements of the sightings, and so are shifts by which their surroundings fall onto themselves, as in a regular
  /// plantation. A pairing is as probable as the hypothesis is beside the placements that contradict it, where chance may find
  /// one, too, and as it is itself beside a feature that is not known yet.
  std::vector<Match> operator()(PairingProblem<Dim> problem);

  /// The placements that are compared, the best first. Choices that are outside of the gates by themselves are taken out of the
  /// problem, which must outlive the placements.
  std::vector<Hypothesis<Dim>> placements(PairingProblem<Dim>& problem);
  /// The match of each pairing of a placement: as probable as it is, given the others, beside a feature that is not known yet.
  std::vector<Match> matches(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement);

  double gate() { return gates_(Dim); }

 private:
  using Forbidden = std::vector<std::vector<std::size_t>>;  // by sighting
  std::vector<std::size_t> gated(PairingProblem<Dim>& problem);
  Hypothesis<Dim> best(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order, const Forbidden& forbidden);
  std::vector<Hypothesis<Dim>> placements(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order);
  double squared_distance(const PairingProblem<Dim>& problem, const Pairing& pairing);
  bool contradicts(const Hypothesis<Dim>& other, const Pairing& pairing);
  Hypothesis<Dim> without(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& all, const Pairing& pairing);
  double odds_of_shifts(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& best, double tolerance2) const;
  void match_jointly(const PairingProblem<Dim>& problem, const std::vector<std::size_t>& order, std::vector<Match>& matches);
  void match_nearest(const PairingProblem<Dim>& problem, std::vector<Match>& matches);

  const NeighbourDensity<Dim>& density_;
  AssociationMethod method_;
  ChiSquaredQuantiles gates_;
};

}  // namespace mapjoin
