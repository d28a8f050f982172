// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The search for the best hypothesis of a matching problem.

#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// By sighting, the known features that it is not to be matched with.
using ForbiddenPairings = std::vector<std::vector<std::size_t>>;

/// The hypothesis of the highest score, sought from sighting to sighting in the given order, following the most promising
/// branches (beam search).
template <int Dim>
Hypothesis<Dim> best_hypothesis(const PairingProblem<Dim>& problem, std::span<const std::size_t> order,
                                const ForbiddenPairings& forbidden, const NeighbourDensity<Dim>& density,
                                ChiSquaredQuantiles& gates);

}  // namespace mapjoin
