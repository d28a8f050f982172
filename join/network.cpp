// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/network.hpp>
#include <mapjoin/localmap/segment.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Condenses the maps once it is known which features nothing else mentions.
template <int Dim>
void add_maps(Network<Dim>& network, std::vector<LocalMap<Dim>> maps) {
  std::vector<bool> mentioned(network.feature_count, false);
  for (const auto* observation : network.feature_observations) mentioned[static_cast<std::size_t>(observation->target)] = true;
  for (const auto* prior : network.feature_priors) mentioned[static_cast<std::size_t>(prior->target)] = true;
  network.is_private = private_features(maps, std::move(mentioned));
  network.maps.resize(maps.size());
  parallel_for(maps.size(), [&](std::size_t k) { network.maps[k] = condense(std::move(maps[k]), network.is_private); });
  for (const auto& condensed : network.maps) {
    for (const Index feature : condensed.map.features) network.is_private[static_cast<std::size_t>(feature)] = false;
  }
}

template <int Dim>
void add_span(Network<Dim>& network, const Log<Dim>& log, const Stretch& stretch) {
  for (const auto& o : odometry_of(log, stretch)) network.pose_observations.push_back(&o);
  for (const auto& o : observations_of(log, stretch)) network.feature_observations.push_back(&o);
}

}  // namespace

template <int Dim>
Network<Dim> network_of(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps) {
  Network<Dim> network;
  network.pose_count = log.poses.size();
  network.feature_count = log.features.size();
  network.stretches = split.stretches;
  network.is_joined = split.kept;
  for (const Stretch& stretch : split.stretches) {
    if (!stretch.is_map) add_span(network, log, stretch);
  }
  for (const auto& closure : log.closures) network.pose_observations.push_back(&closure);
  for (const auto& prior : log.pose_priors) network.pose_priors.push_back(&prior);
  for (const auto& prior : log.feature_priors) network.feature_priors.push_back(&prior);
  network.fixed = log.fixed;
  add_maps(network, std::move(maps));
  return network;
}

template <int Dim>
Network<Dim> network_of(const MapSet<Dim>& set, std::vector<LocalMap<Dim>> maps) {
  Network<Dim> network;
  network.pose_count = set.poses.size();
  network.feature_count = set.features.size();
  network.stretches = set.stretches;
  network.is_joined.assign(set.poses.size(), true);
  for (const auto& o : set.pose_observations)
    (o.base == kWorld ? network.pose_priors : network.pose_observations).push_back(&o);
  for (const auto& o : set.feature_observations) {
    (o.base == kWorld ? network.feature_priors : network.feature_observations).push_back(&o);
  }
  network.fixed = set.fixed;
  for (LocalMap<Dim>& map : maps) {
    map.information = (0.5 * (map.information + map.information.transpose())).eval();  // a filter leaves it asymmetric
  }
  add_maps(network, std::move(maps));
  return network;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                               \
  template Network<Dim> network_of(const Log<Dim>&, const Split&, std::vector<LocalMap<Dim>>); \
  template Network<Dim> network_of(const MapSet<Dim>&, std::vector<LocalMap<Dim>>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
