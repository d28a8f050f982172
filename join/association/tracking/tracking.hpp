// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tracking of observations from pose to pose, to find those of the same feature within a segment.

#include <mapjoin/join/association/matching/matching.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <vector>

namespace mapjoin {

/// The feature that an observation was found to be of.
struct Tracked {
  std::size_t feature = 0;     ///< Number within the segment, from 0 in the order of first sighting.
  std::optional<Match> match;  ///< Match with the feature; nullopt if the observation is the first one of it so far.
};

/// What tracking finds in a segment.
template <int Dim>
struct Tracks {
  std::vector<Tracked> observations;  ///< The feature of each observation of the segment, in their order.
  std::vector<SightingTrial> trials;  ///< Of each pose that sees anything, with each feature seen before it.
  std::vector<Point<Dim>> followed;   ///< The features seen more than once, in the frame of the last pose (m).
};

/// Tracks the observations of a segment.
///
/// The observations of one pose are matched together with the features seen before, as a FeatureFilter predicts them. An
/// observation far from all of them starts a tentative feature. A match that is probable enough is accepted. Any other
/// observation is set aside, as a feature of its own that nothing is matched with here: more will be known of it later. `sees`
/// is the chance that a pose sees a feature.
template <int Dim>
Tracks<Dim> track(const SegmentView<Dim>& segment, const SightingChance& sees, Matcher<Dim>& matcher, double confidence);

}  // namespace mapjoin
