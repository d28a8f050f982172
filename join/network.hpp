// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What is joined: local maps without their private features, and the observations that stand on their own.

#include <mapjoin/localmap/condense.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/map_set.hpp>
#include <vector>

namespace mapjoin {

/// Views into a log or a map set, which must outlive it. Observations are pointers: a log has millions.
template <int Dim>
struct Network {
  std::size_t pose_count = 0;
  std::size_t feature_count = 0;
  std::vector<CondensedMap<Dim>> maps;  ///< Of the stretches that are maps, in their order.
  FactorSelection<Dim> factors;         ///< What stands on its own: of spans, and closures.
  FactorSelection<Dim> priors;
  std::vector<FixedPose<Dim>> fixed;
  std::vector<Stretch> stretches;
  std::vector<bool> is_private;  ///< Per feature: eliminated within its map.
  std::vector<bool> is_joined;   ///< Per pose: part of the joined state.
};

/// The network of a log split into stretches, with the local maps of those that are maps.
template <int Dim>
Network<Dim> network_of(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps);

/// The network of a set of local maps; `maps` are those of the set, which need not hold them any more.
template <int Dim>
Network<Dim> network_of(const MapSet<Dim>& set, std::vector<LocalMap<Dim>> maps);
template <int Dim>
Network<Dim> network_of(const MapSet<Dim>& set) {
  return network_of(set, set.graph.submaps);
}

}  // namespace mapjoin
