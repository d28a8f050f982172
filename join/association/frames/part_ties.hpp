// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Ties, by shared features, between parts of a log or a set that nothing else ties together, such as sessions of unknown
// frames.

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/frames/map_alignment.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <stop_token>
#include <utility>
#include <vector>

namespace mapjoin {

/// Two parts that were not aligned.
struct PartsApart {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  MapAlignment alignment;
};

struct PartTies {
  std::vector<std::pair<FeatureIndex, FeatureIndex>> ties;  ///< Features of two parts that are the same.
  std::vector<PartsApart> apart;
};

/// Aligns every pair of parts. A spanning forest of the alignments found, by descending score, ties the parts; the others are
/// tested once these are joined. Errors as of MapCovariances::joint(); kInterrupted on `stop`.
template <int Dim>
Expected<PartTies> ties_between_parts(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                                      const NeighbourDensity<Dim>& density, double confidence, const std::stop_token& stop);

}  // namespace mapjoin
