// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/covariances/relations.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
template <int Dim>
Relations<Dim> relations_of(const Restored<Dim>& restored) {
  const JoiningSystem<Dim>& system = restored.system;
  const Values<Dim>& state = system.estimate();
  const PartialMap<Dim>& joined_map = restored.joined_map;
  const auto pose_at = [&](PoseIndex place) { return place == kWorld ? kWorld : joined_map.poses[place]; };
  Relations<Dim> relations;
  relations.poses.resize(restored.graph.pose_count);
  relations.features.resize(restored.graph.feature_count);
  const auto relate_pose = [&](PoseIndex place, PoseIndex parent) {
    const PoseIndex pose = pose_at(place);
    relations.poses[pose] = {pose_at(parent), between(state.pose(parent), state.pose(place))};
    relations.order.push_back(pose);
  };
  for (const PoseIndex place : indices(joined_map.poses)) {
    if (system.is_anchored(place)) relate_pose(place, kWorld);
  }
  const SpanningTree tree = spanning_tree(system);
  for (const auto& edge : tree.poses) relate_pose(edge.child, edge.parent);
  for (const auto& edge : tree.features) {
    relations.features[joined_map.features[edge.child]] = {pose_at(edge.parent),
                                                           transform_into(state.pose(edge.parent), state.features[edge.child])};
  }
  return relations;
}

template <int Dim>
Values<Dim> composed(const Relations<Dim>& relations) {
  Values<Dim> state;
  state.poses.resize(relations.poses.size());
  for (const PoseIndex pose : relations.order) {
    const PoseRelation<Dim>& relation = relations.poses[pose];
    state.poses[pose] = compose(state.pose(relation.parent), relation.value);
  }
  for (const FeatureRelation<Dim>& relation : relations.features) {
    state.features.push_back(transform(state.pose(relation.parent), relation.value));
  }
  return state;
}

#define MAPJOIN_INSTANTIATE(Dim)                              \
  template Relations<Dim> relations_of(const Restored<Dim>&); \
  template Values<Dim> composed(const Relations<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
