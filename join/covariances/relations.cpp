// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/covariances/relations.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
template <int Dim>
Relations<Dim> relations_of(const Restored<Dim>& restored) {
  const JointSystem<Dim>& system = restored.problem.system();
  const State<Dim>& state = system.estimate();
  const Piece<Dim>& whole = restored.whole;
  const auto pose_at = [&](Index place) { return place == kWorld ? kWorld : whole.poses[static_cast<std::size_t>(place)]; };
  Relations<Dim> relations;
  relations.poses.resize(restored.network.pose_count);
  relations.features.resize(restored.network.feature_count);
  const auto relate_pose = [&](Index place, Index parent) {
    const Index pose = pose_at(place);
    relations.poses[static_cast<std::size_t>(pose)] = {pose_at(parent), between(state.pose(parent), state.pose(place))};
    relations.order.push_back(pose);
  };
  for (Index place = 0; place < static_cast<Index>(whole.poses.size()); ++place) {
    if (system.is_held(place)) relate_pose(place, kWorld);
  }
  const SpanningTree tree = spanning_tree(system);
  for (const TreeEdge& edge : tree.poses) relate_pose(edge.child, edge.parent);
  for (const TreeEdge& edge : tree.features) {
    const auto feature = static_cast<std::size_t>(whole.features[static_cast<std::size_t>(edge.child)]);
    relations.features[feature] = {pose_at(edge.parent), transform_into(state.pose(edge.parent), state.feature(edge.child))};
  }
  return relations;
}

template <int Dim>
State<Dim> composed(const Relations<Dim>& relations) {
  State<Dim> state;
  state.poses.resize(relations.poses.size());
  for (const Index pose : relations.order) {
    const PoseRelation<Dim>& relation = relations.poses[static_cast<std::size_t>(pose)];
    state.poses[static_cast<std::size_t>(pose)] = compose(state.pose(relation.parent), relation.placement);
  }
  for (const FeatureRelation<Dim>& relation : relations.features) {
    state.features.push_back(transform(state.pose(relation.parent), relation.placement));
  }
  return state;
}

#define MAPJOIN_INSTANTIATE(Dim)                              \
  template Relations<Dim> relations_of(const Restored<Dim>&); \
  template State<Dim> composed(const Relations<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
