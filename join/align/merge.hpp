// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Merging partial maps that share something, along the graph of submaps.

#include <mapjoin/join/align/partial_map.hpp>
#include <vector>

namespace mapjoin {

/// Merges partial maps that are tied by poses, features or closures until none are, each in the frame of the first, from
/// neighbour to neighbour in the graph of submaps. Of several alignments the one of least chi2 is taken or, without
/// `tries_hypotheses`, the first. Neighbours that share nothing with any other are merged at once.
template <int Dim>
std::vector<PartialMap<Dim>> merge_tied(std::vector<PartialMap<Dim>> partials,
                                        const std::vector<const PoseFactor<Dim>*>& closures, bool tries_hypotheses);

}  // namespace mapjoin
