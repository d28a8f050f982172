// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tracking over a whole log, which learns on the way how densely features stand and how surely they are seen.

#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/join/association/tracking/tracking.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/log.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Tracks all observations of a log, segment by segment; features are numbered consecutively over all segments.
///
/// But for nearest neighbours this is done three times. The first time no more is known than the `density` of what is seen at
/// once. Each next time the chance of overlooking a feature is known from how often poses saw those around them, and the
/// overall density is that of the features that were followed, or that of what is seen at once if it is higher; `density` has
/// the last one in the end. Incomplete once a stop is requested.
template <int Dim>
std::vector<Tracked> track_log(const Log<Dim>& log, const Split& split, const AssociationOptions& options,
                               NeighbourDensity<Dim>& density, const std::stop_token& stop);

}  // namespace mapjoin
