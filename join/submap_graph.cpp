// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Adds the maps, with the features marginalised that nothing else mentions; `referenced` marks features that others mention.
template <int Dim>
void add_maps(SubmapGraph<Dim>& graph, std::vector<LocalMap<Dim>> maps, Table<FeatureIndex, bool> referenced = {}) {
  referenced.resize(graph.feature_count, false);
  for (const auto* selection : {&graph.factors, &graph.priors}) {
    for (const auto* factor : selection->feature_factors) referenced[factor->target] = true;
  }
  graph.is_local = local_features(maps, std::move(referenced));
  graph.maps.resize(maps.size());
  parallel_for(maps.size(), [&](std::size_t k) { graph.maps[k] = marginalise(std::move(maps[k]), graph.is_local); });
  for (const auto& marginalised : graph.maps) {
    for (const FeatureIndex feature : marginalised.map.features) graph.is_local[feature] = false;
  }
}

template <typename Factors, typename Selected>
void select(const Factors& factors, Selected& selected) {
  for (const auto& factor : factors) selected.push_back(&factor);
}

/// The submap graph of a log or a set, without maps, fixed poses and single observations.
template <template <int> typename Data, int Dim>
SubmapGraph<Dim> bare_submap_graph(const Data<Dim>& data, const std::vector<Segment>& segments) {
  SubmapGraph<Dim> graph;
  graph.pose_count = data.poses.size();
  graph.feature_count = data.features.size();
  graph.segments = segments;
  return graph;
}

}  // namespace

template <int Dim>
SubmapGraph<Dim> submap_graph_of(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                 Table<FeatureIndex, bool> elsewhere) {
  SubmapGraph<Dim> graph = bare_submap_graph(log, split.segments);
  graph.fixed = log.graph.fixed;
  graph.is_joined = split.kept;
  for (const Segment& segment : split.segments) {
    if (segment.is_map) continue;
    select(odometry_of(log, segment), graph.factors.pose_factors);
    select(observations_of(log, segment), graph.factors.feature_factors);
  }
  select(log.closures(), graph.factors.pose_factors);
  select(log.pose_priors(), graph.priors.pose_factors);
  select(log.feature_priors(), graph.priors.feature_factors);
  add_maps(graph, std::move(maps), std::move(elsewhere));
  return graph;
}

template <int Dim>
SubmapGraph<Dim> submap_graph_of(const SubmapSet<Dim>& set, std::vector<LocalMap<Dim>> maps) {
  SubmapGraph<Dim> graph = bare_submap_graph(set, set.segments);
  graph.fixed = fixed_once(set.graph.fixed, set.poses).value();
  graph.is_joined.assign(set.poses.size(), true);
  for (const auto& o : set.graph.pose_factors) {
    (o.base == kWorld ? graph.priors : graph.factors).pose_factors.push_back(&o);
  }
  for (const auto& o : set.graph.feature_factors) {
    (o.base == kWorld ? graph.priors : graph.factors).feature_factors.push_back(&o);
  }
  for (LocalMap<Dim>& map : maps) {
    map.information = (0.5 * (map.information + map.information.transpose())).eval();  // a filter leaves it asymmetric
  }
  add_maps(graph, std::move(maps));
  return graph;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                       \
  template SubmapGraph<Dim> submap_graph_of(const Log<Dim>&, const Split&, std::vector<LocalMap<Dim>>, \
                                            Table<FeatureIndex, bool>);                                \
  template SubmapGraph<Dim> submap_graph_of(const SubmapSet<Dim>&, std::vector<LocalMap<Dim>>);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
