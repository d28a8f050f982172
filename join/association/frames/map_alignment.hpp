// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where one map lies in another whose frame is not known, by the constellations of their features; nowhere, where that is not
// sure.

#include <cmath>
#include <cstdint>
#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/frames/sighting_chance.hpp>
#include <mapjoin/join/association/neighbour_density.hpp>
#include <vector>

namespace mapjoin {

enum class AlignmentStatus : std::uint8_t {
  kFound,      ///< There is one way in which the maps lie on each other.
  kNone,       ///< There is none that chance would not find as well.
  kAmbiguous,  ///< There are several.
  kRepeated,   ///< What was paired lies so elsewhere in the larger map, too.
};

/// Which features of two maps are the same.
struct MapAlignment {
  AlignmentStatus status = AlignmentStatus::kNone;
  std::vector<Pairing> pairs;   ///< Features of the first map (known) and of the second (sightings), of the best candidate.
  double score = 0.0;           ///< Its logarithm of odds, against maps that do not overlap.
  std::size_t other_pairs = 0;  ///< Of the best candidate that contradicts it; 0 where there is none.
  double other_score = 0.0;
};

/// What is known of features and sightings whatever the alignment.
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
/// From constellations that look alike, the most promising ones first, pairings are extended from neighbour to neighbour by
/// joint compatibility (Hypothesis), over the covariances of both maps and a relative pose that may be anything. The score is
/// the logarithm of the odds against maps that do not overlap: each pairing counts by how much nearer it is than chance would
/// have it, what one map should have seen of the other and did not counts against it, and so do all the relative poses that
/// there could have been. A candidate is taken where the odds are those of `confidence` for every pairing of features that it
/// may have begun with, and no other one that contradicts it has half its score; nor may what was paired lie so in the larger
/// map once more, with half that score: then the world repeats itself.
template <int Dim>
MapAlignment align_maps(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, const AlignmentModel<Dim>& model);

}  // namespace mapjoin
