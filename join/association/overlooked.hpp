// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Features that a map should have seen and did not: evidence against a placement of two maps.

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/hypothesis.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/join/association/neighbour_density.hpp>
#include <mapjoin/join/association/sighting_chance.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <vector>

namespace mapjoin {

/// The logarithm of the chance that, where a placement lays two maps on each other, each overlooked all features of the other
/// for which it has none that fits; 0 if the chance of a sighting is not known, or nothing is paired.
template <int Dim>
double log_overlooked(const PairingProblem<Dim>& problem, const Hypothesis<Dim>& placement,
                      const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates);

/// The chance that a local map sees a feature, by the distance of the nearest other one that it sees (m), learnt from local
/// maps that follow each other. `unclear`, by map, are features of it and of the one before it that may be the same, which tell
/// nothing.
template <int Dim>
SightingChance chance_of_maps(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                              const std::vector<std::vector<FeatureIndex>>& unclear);

}  // namespace mapjoin
