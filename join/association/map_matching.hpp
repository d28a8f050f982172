// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Matching of the features of different local maps, by the joined map of the identities known so far.

#include <mapjoin/join/association/feature_candidates.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/join/association/matching/matching.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <set>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Two features that may be the same.
struct FeaturePair {
  FeatureIndex one;
  FeatureIndex other;
  bool operator==(const FeaturePair&) const = default;
};

/// Two features that are probably the same.
struct Proposal {
  FeatureIndex one;
  FeatureIndex other;
  Match match;
  std::size_t maps[2] = {0, 0};  ///< The maps that were matched, the earlier one first.
};

struct Proposals {
  std::vector<Proposal> probable;  ///< Ordered by the later map: those within it, then by the earlier map.
  std::size_t beyond_reach = 0;    ///< Number of pairs of maps that were not tried.
};

/// Two maps with features that may be the same.
template <int Dim>
struct MapPair {
  std::size_t maps[2] = {0, 0};  ///< The earlier one first.
  FeaturePair features;          ///< One feature of each map: the pair that may be mistaken for the fewest others.
  double confusable = 0.0;       ///< Number of others that the features may be mistaken for.
  PointMatrix<Dim> covariance;   ///< Covariance of the difference of the features (m²).
};

/// Matches pairs of maps with each other, by the joint covariance of their features in the joined map.
template <int Dim>
class MapMatching {
 public:
  /// No right match is outside of the gates of so many `decisions`, with the confidence. The references must outlive this.
  MapMatching(const FeatureEstimate<Dim>& estimate, const Identities& identities, const NeighbourDensity<Dim>& density,
              AssociationMethod method, double confidence, double decisions);

  /// Matches of pairs of maps whose features may coincide, and of set-aside sightings within a map. A pair of maps is tried
  /// only if none of its features may be mistaken for more than `reach` others, given the uncertainty of the maps. With
  /// `only_neighbours` maps are matched with the one before them only.
  Proposals propose(double reach, bool only_neighbours, const std::stop_token& stop) const;
  /// All pairs of maps with two features that may be the same and may be mistaken for at most `reach` others; ordered by the
  /// later map, then the earlier one.
  std::vector<MapPair<Dim>> pairs(double reach, const std::stop_token& stop) const;
  /// The chance that a map sees a feature, by the distance of the nearest other one that it sees (m).
  const SightingChance& map_sees() const { return map_sees_; }
  /// A matcher with the gates of all decisions.
  Matcher<Dim> matcher() const;
  /// The probability asked of the place of a map beside another one, so that with the confidence all maps are in their places:
  /// one that is not bends the joined map.
  double placement_confidence() const;
  /// The logarithm of the number of all pairs of maps.
  double log_pairs() const;

 private:
  MatchedMap<Dim> features_of(std::size_t map, std::size_t other, const std::set<FeatureIndex>& candidates) const;
  std::vector<MapPair<Dim>> pairs_of(std::size_t map, double reach) const;
  Proposals of_map(std::size_t map, double reach, bool only_neighbours, const std::stop_token& stop) const;
  Proposals of_pair(std::size_t earlier, std::size_t later, const OpenFeatures<Dim>& open, double reach,
                    Matcher<Dim>& matcher) const;
  Proposals within(std::size_t map, const OpenFeatures<Dim>& open, Matcher<Dim>& matcher) const;
  PairingProblem<Dim> problem(const std::vector<FeatureIndex>& known, const std::vector<std::size_t>& open_places,
                              const OpenFeatures<Dim>& open, std::size_t known_map) const;
  Eigen::MatrixXd joint(const std::vector<FeatureIndex>& features, std::size_t map) const;

  const FeatureEstimate<Dim>& estimate_;
  const Identities& identities_;
  const NeighbourDensity<Dim>& density_;
  AssociationMethod method_;
  double confidence_;
  double decisions_;
  FeatureCandidates<Dim> candidates_;
  SightingChance map_sees_;
};

}  // namespace mapjoin
