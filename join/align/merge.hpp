// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Merging pieces that share something, along the graph of submaps.

#include <mapjoin/join/align/piece.hpp>
#include <vector>

namespace mapjoin {

/// Merges pieces that are tied by poses, features or closures until none are, each in the frame of the first, from neighbour to
/// neighbour in the graph of submaps. Of several placements the one of least chi2 is taken or, without `tries_hypotheses`, the
/// first. Neighbours that share nothing with any other are merged at once.
template <int Dim>
std::vector<Piece<Dim>> merge_tied(std::vector<Piece<Dim>> pieces, const std::vector<const PoseObservation<Dim>*>& closures,
                                   bool tries_hypotheses);

}  // namespace mapjoin
