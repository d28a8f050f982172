// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The agreement of an association with the names in its input, counted by pairs of sightings.

#include <map>
#include <mapjoin/join/association/associate.hpp>
#include <utility>
#include <vector>

namespace mapjoin::testing {

struct PairScore {
  double precision = 1.0;  ///< The share of pairs of one name among the pairs that were made one feature.
  double recall = 1.0;     ///< The share of pairs that were made one feature among the pairs of one name.
};

/// The score of sightings, each given by its name and the feature that it was made.
template <typename Name, typename Joined>
PairScore pair_score(const std::vector<std::pair<Name, Joined>>& sightings) {
  std::map<Name, double> named;
  std::map<Joined, double> joined;
  std::map<std::pair<Name, Joined>, double> both;
  for (const auto& sighting : sightings) {
    ++named[sighting.first];
    ++joined[sighting.second];
    ++both[sighting];
  }
  const auto pairs = [](const auto& counts) {
    double sum = 0.0;
    for (const auto& [key, count] : counts) sum += 0.5 * count * (count - 1.0);
    return sum;
  };
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 1.0; };
  return {share(pairs(both), pairs(joined)), share(pairs(both), pairs(named))};
}

inline PairScore pair_score(const std::vector<AssociatedSighting>& sightings) {
  std::vector<std::pair<FeatureId, FeatureId>> pairs;
  for (const AssociatedSighting& s : sightings) pairs.emplace_back(s.name, s.joined);
  return pair_score(pairs);
}

}  // namespace mapjoin::testing
