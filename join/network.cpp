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
  for (const auto* selection : {&network.factors, &network.priors}) {
    for (const auto* factor : selection->feature_factors) mentioned[static_cast<std::size_t>(factor->target)] = true;
  }
  network.is_private = private_features(maps, std::move(mentioned));
  network.maps.resize(maps.size());
  parallel_for(maps.size(), [&](std::size_t k) { network.maps[k] = condense(std::move(maps[k]), network.is_private); });
  for (const auto& condensed : network.maps) {
    for (const Index feature : condensed.map.features) network.is_private[static_cast<std::size_t>(feature)] = false;
  }
}

template <typename Factors, typename Selected>
void select(const Factors& factors, Selected& selected) {
  for (const auto& factor : factors) selected.push_back(&factor);
}

/// The network of a log or a set, without its maps and what stands on its own.
template <template <int> typename Data, int Dim>
Network<Dim> bare_network(const Data<Dim>& data, const std::vector<Stretch>& stretches) {
  Network<Dim> network;
  network.pose_count = data.poses.size();
  network.feature_count = data.features.size();
  network.fixed = data.graph.fixed;
  network.stretches = stretches;
  return network;
}

}  // namespace

template <int Dim>
Network<Dim> network_of(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps) {
  Network<Dim> network = bare_network(log, split.stretches);
  network.is_joined = split.kept;
  for (const Stretch& stretch : split.stretches) {
    if (stretch.is_map) continue;
    select(odometry_of(log, stretch), network.factors.pose_factors);
    select(observations_of(log, stretch), network.factors.feature_factors);
  }
  select(log.closures(), network.factors.pose_factors);
  select(log.pose_priors(), network.priors.pose_factors);
  select(log.feature_priors(), network.priors.feature_factors);
  add_maps(network, std::move(maps));
  return network;
}

template <int Dim>
Network<Dim> network_of(const MapSet<Dim>& set, std::vector<LocalMap<Dim>> maps) {
  Network<Dim> network = bare_network(set, set.stretches);
  network.is_joined.assign(set.poses.size(), true);
  for (const auto& o : set.graph.pose_factors) {
    (o.base == kWorld ? network.priors : network.factors).pose_factors.push_back(&o);
  }
  for (const auto& o : set.graph.feature_factors) {
    (o.base == kWorld ? network.priors : network.factors).feature_factors.push_back(&o);
  }
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
