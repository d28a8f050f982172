// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Constellations: features with their neighbours that look alike in two maps, whatever the frames of these are.

#include <mapjoin/join/association/frames/feature_map.hpp>
#include <mapjoin/join/association/hypothesis.hpp>
#include <vector>

namespace mapjoin {

/// A feature and some of its neighbours: pairings of features of a first map (known) with those of a second one (sightings),
/// the feature itself first.
using Constellation = std::vector<Pairing>;

/// The constellations that look alike in both maps, of four features at least.
///
/// Triangles of a feature and two of its nearest neighbours are found in the other map by the lengths of their sides (a k-d
/// tree), within what the covariances allow with probability `confidence`. Where several triangles of two features agree which
/// neighbour is which, those of the largest clique are a constellation. Triangles that look like very many others, as in a
/// regular plantation, are compared with some of these only.
template <int Dim>
std::vector<Constellation> constellations_alike(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, double confidence);

}  // namespace mapjoin
