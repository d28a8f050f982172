// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The alignment of two maps of unknown relative pose by the constellations of their features, or none if it is not certain.

#include <cmath>
#include <cstdint>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <vector>

namespace mapjoin {

enum class AlignmentStatus : std::uint8_t {
  kFound,      ///< One alignment is probable.
  kNone,       ///< No alignment is more probable than by chance.
  kAmbiguous,  ///< Several alignments that contradict each other are probable.
  kRepeated,   ///< The paired features repeat elsewhere in the larger map.
};

/// The best alignment of two maps, by pairings of their features.
struct MapAlignment {
  AlignmentStatus status = AlignmentStatus::kNone;
  std::vector<Pairing> pairs;   ///< Features of the first map (known) and of the second (sightings), of the best candidate and
                                ///< those that agree with it.
  double score = 0.0;           ///< Logarithm of the odds of the best candidate against maps that do not overlap.
  std::size_t other_pairs = 0;  ///< Number of pairings of the best candidate that contradicts it; 0 if none.
  double other_score = 0.0;
};

/// A model of features and sightings that does not depend on the alignment.
template <int Dim>
struct AlignmentModel {
  const NeighbourDensity<Dim>& density;
  const SightingChance& sees;
  double confidence = 0.99;
  double log_tests = 0.0;  ///< The logarithm of the number of pairs of maps that are tried.

  /// The logarithm of the odds of `confidence`.
  double log_odds() const { return std::log(confidence / (1.0 - confidence)); }
};

/// Aligns two maps.
///
/// Pairings are extended from constellations that look alike, the most promising ones first, from neighbour to neighbour by
/// joint compatibility (Hypothesis), over the covariances of both maps and an arbitrary relative pose. The score is the
/// logarithm of the odds against maps that do not overlap: each pairing counts by how much nearer it is than by chance;
/// features that the other map should have seen but did not count against it, and so do all possible relative poses. The best
/// candidate is accepted if its odds, divided by the numbers of pairs of maps and of features that it may have begun with,
/// reach those of `confidence`, if no candidate that contradicts it has half its score, and if its features do not repeat
/// elsewhere in the larger map with half that score.
template <int Dim>
MapAlignment align_maps(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model);

}  // namespace mapjoin
