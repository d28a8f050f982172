// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which observations within a segment are of the same feature: they are followed from pose to pose.

#include <mapjoin/join/association/matching.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <vector>

namespace mapjoin {

/// What an observation was taken for.
struct Tracked {
  std::size_t feature = 0;     ///< Within the segment, counted from 0 in the order of first sighting.
  std::optional<Match> match;  ///< Nothing where it is the first one, for now, of its feature.
};

/// For each observation of a segment, in their order, its feature.
///
/// The observations of one pose are matched together with the features that were seen before, as a FeatureFilter predicts
/// them. What is far from all of them starts a tentative feature. What is probable enough is taken. What could be either is
/// set aside, as a feature of its own that nothing is matched with here: more will be known of it later.
template <int Dim>
std::vector<Tracked> track(const SegmentView<Dim>& segment, Matcher<Dim>& matcher, double confidence);

}  // namespace mapjoin
