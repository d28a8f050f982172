// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Parts of a log or a set of maps that nothing ties together, sessions of unknown frames say, tied by the features that they
// share.

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

/// Aligns every pair of parts. Of the alignments found those of the highest scores tie the parts into as few as they can; what
/// the others say will be seen once these are joined. Errors as of MapCovariances::joint(); kInterrupted on `stop`.
template <int Dim>
Expected<PartTies> ties_between_parts(const FeatureEstimate<Dim>& estimate, const Identities& identities,
                                      const NeighbourDensity<Dim>& density, double confidence, const std::stop_token& stop);

}  // namespace mapjoin
