// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/restored.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
SubmapGraph<Dim> restored_submap_graph(const SubmapGraph<Dim>& graph, const std::vector<SegmentView<Dim>>& segments) {
  SubmapGraph<Dim> all{.pose_count = graph.pose_count,
                       .feature_count = graph.feature_count,
                       .maps = {},
                       .factors = graph.factors,
                       .priors = graph.priors,
                       .fixed = graph.fixed,
                       .segments = graph.segments,
                       .is_local = Table<FeatureIndex, bool>(graph.feature_count, false),
                       .is_joined = graph.is_joined};
  for (const SegmentView<Dim>& segment : segments) {
    for (const auto& o : segment.odometry) all.factors.pose_factors.push_back(&o);
    for (const auto& o : segment.observations) all.factors.feature_factors.push_back(&o);
    for (const PoseIndex pose : segment.interior) all.is_joined[pose] = true;
  }
  if (!segments.empty()) return all;
  for (const auto& map : graph.maps) all.maps.push_back({restored(map), {}, {}, {}, {}});
  return all;
}

/// The elimination order by places: map by map the interior poses along the segment, then the submap-local features; last the
/// order of the join.
template <int Dim>
std::vector<PoseOrFeature> restored_order(const SubmapGraph<Dim>& graph, const std::vector<SegmentView<Dim>>& segments,
                                          const Join<Dim>& join, const PartialMap<Dim>& joined_map) {
  std::vector<PoseOrFeature> order;
  const auto add_pose = [&](PoseIndex pose) { order.emplace_back(place_of(joined_map.poses, pose)); };
  const auto add_feature = [&](FeatureIndex feature) { order.emplace_back(place_of(joined_map.features, feature)); };
  for (std::size_t m = 0; m < graph.maps.size(); ++m) {
    if (!segments.empty()) std::for_each(segments[m].interior.begin(), segments[m].interior.end(), add_pose);
    for (const FeatureIndex feature : graph.maps[m].local_features) add_feature(feature);
  }
  for (const Variable variable : join.system->equations().order()) {
    const PoseOrFeature place = join.system->place_of_variable(variable);
    if (const auto* pose = std::get_if<PoseIndex>(&place)) {
      add_pose(join.poses[*pose]);
    } else {
      add_feature(join.features[std::get<FeatureIndex>(place)]);
    }
  }
  return order;
}

}  // namespace

template <int Dim>
Restored<Dim> restored(const SubmapGraph<Dim>& graph, const std::vector<SegmentView<Dim>>& segments, Join<Dim>& join,
                       const Values<Dim>& state, Engine engine) {
  SubmapGraph<Dim> all = restored_submap_graph(graph, segments);
  PartialMap<Dim> joined_map = joined_map_of(all);
  joined_map.state = restricted(state, joined_map);
  if (graph.maps.empty()) return {std::move(all), std::move(joined_map), std::move(*join.system)};
  const std::vector<PoseOrFeature> order = restored_order(graph, segments, join, joined_map);
  JoiningSystem<Dim> system(joined_map, gauge_of(all, joined_map), engine, order);
  return {std::move(all), std::move(joined_map), std::move(system)};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template Restored<Dim> restored(const SubmapGraph<Dim>&, const std::vector<SegmentView<Dim>>&, Join<Dim>&, \
                                  const Values<Dim>&, Engine);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
