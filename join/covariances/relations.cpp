// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/covariances/relations.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
template <int Dim>
Relations<Dim> relations_of(const Restored<Dim>& restored) {
  const JoiningSystem<Dim>& system = restored.problem.system();
  const Values<Dim>& state = system.estimate();
  const PartialMap<Dim>& joined_map = restored.joined_map;
  const auto pose_at = [&](Index place) {
    return place == kWorld ? kWorld : joined_map.poses[static_cast<std::size_t>(place)];
  };
  Relations<Dim> relations;
  relations.poses.resize(restored.graph.pose_count);
  relations.features.resize(restored.graph.feature_count);
  const auto relate_pose = [&](Index place, Index parent) {
    const Index pose = pose_at(place);
    relations.poses[static_cast<std::size_t>(pose)] = {pose_at(parent), between(state.pose(parent), state.pose(place))};
    relations.order.push_back(pose);
  };
  for (Index place = 0; place < static_cast<Index>(joined_map.poses.size()); ++place) {
    if (system.is_anchored(place)) relate_pose(place, kWorld);
  }
  const SpanningTree tree = spanning_tree(system);
  for (const TreeEdge& edge : tree.poses) relate_pose(edge.child, edge.parent);
  for (const TreeEdge& edge : tree.features) {
    const auto feature = static_cast<std::size_t>(joined_map.features[static_cast<std::size_t>(edge.child)]);
    relations.features[feature] = {pose_at(edge.parent), transform_into(state.pose(edge.parent), state.feature(edge.child))};
  }
  return relations;
}

template <int Dim>
Values<Dim> composed(const Relations<Dim>& relations) {
  Values<Dim> state;
  state.poses.resize(relations.poses.size());
  for (const Index pose : relations.order) {
    const PoseRelation<Dim>& relation = relations.poses[static_cast<std::size_t>(pose)];
    state.poses[static_cast<std::size_t>(pose)] = compose(state.pose(relation.parent), relation.value);
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
