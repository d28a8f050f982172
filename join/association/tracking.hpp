// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tracking of observations from pose to pose, to find those of the same feature within a segment.

#include <mapjoin/join/association/matching.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <vector>

namespace mapjoin {

/// The feature that an observation was found to be of.
struct Tracked {
  std::size_t feature = 0;     ///< Number within the segment, from 0 in the order of first sighting.
  std::optional<Match> match;  ///< Match with the feature; nullopt if the observation is the first one of it so far.
};

/// The feature of each observation of a segment, in their order.
///
/// The observations of one pose are matched together with the features seen before, as a FeatureFilter predicts them. An
/// observation far from all of them starts a tentative feature. A match that is probable enough is accepted. Any other
/// observation is set aside, as a feature of its own that nothing is matched with here: more will be known of it later.
template <int Dim>
std::vector<Tracked> track(const SegmentView<Dim>& segment, Matcher<Dim>& matcher, double confidence);

}  // namespace mapjoin
