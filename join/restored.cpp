// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/align/whole.hpp>
#include <mapjoin/join/restored.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
Network<Dim> restored_network(const Network<Dim>& network, const std::vector<Segment<Dim>>& segments) {
  Network<Dim> all{.pose_count = network.pose_count,
                   .feature_count = network.feature_count,
                   .maps = {},
                   .factors = network.factors,
                   .priors = network.priors,
                   .fixed = network.fixed,
                   .stretches = network.stretches,
                   .is_private = std::vector<bool>(network.feature_count, false),
                   .is_joined = network.is_joined};
  for (const Segment<Dim>& segment : segments) {
    for (const auto& o : segment.odometry) all.factors.pose_factors.push_back(&o);
    for (const auto& o : segment.observations) all.factors.feature_factors.push_back(&o);
    for (const Index pose : segment.interior) all.is_joined[static_cast<std::size_t>(pose)] = true;
  }
  if (!segments.empty()) return all;
  for (const auto& map : network.maps) all.maps.push_back({uncondensed(map), {}, {}, {}, {}});
  return all;
}

/// Places of the whole: interior poses along their segment, then submap-local features, map by map; then the order of the join.
template <int Dim>
std::vector<Index> restored_order(const Network<Dim>& network, const std::vector<Segment<Dim>>& segments, const Join<Dim>& join,
                                  const Piece<Dim>& whole) {
  std::vector<Index> order;
  const auto add_pose = [&](Index pose) { order.push_back(place_of(whole.poses, pose)); };
  const auto add_feature = [&](Index feature) {
    order.push_back(static_cast<Index>(whole.poses.size()) + place_of(whole.features, feature));
  };
  for (std::size_t m = 0; m < network.maps.size(); ++m) {
    if (!segments.empty()) std::for_each(segments[m].interior.begin(), segments[m].interior.end(), add_pose);
    for (const Index feature : network.maps[m].private_features) add_feature(feature);
  }
  for (const Variable variable : join.system->equations().order()) {
    const auto place = static_cast<std::size_t>(join.system->place_of_variable(variable));
    if (place < join.poses.size()) {
      add_pose(join.poses[place]);
    } else {
      add_feature(join.features[place - join.poses.size()]);
    }
  }
  return order;
}

}  // namespace

template <int Dim>
Restored<Dim> restored(const Network<Dim>& network, const std::vector<Segment<Dim>>& segments, const Join<Dim>& join,
                       const State<Dim>& state, Engine engine) {
  Network<Dim> all = restored_network(network, segments);
  Piece<Dim> whole = whole_of(all);
  set_to_values(state, whole);
  const std::vector<Index> order = restored_order(network, segments, join, whole);
  JoinProblem<Dim> problem(JointSystem<Dim>(whole, gauge_of(all, whole), engine, order));
  return {std::move(all), std::move(whole), std::move(problem)};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                              \
  template Restored<Dim> restored(const Network<Dim>&, const std::vector<Segment<Dim>>&, const Join<Dim>&, const State<Dim>&, \
                                  Engine);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
