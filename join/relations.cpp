// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/relations.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
namespace {

/// Parents and the order of the poses.
template <int Dim>
void hang(const Network<Dim>& network, const Join<Dim>& join, const std::vector<Segment<Dim>>& segments,
          Relations<Dim>& relations) {
  const auto pose_at = [&](Index place) { return place == kWorld ? kWorld : join.poses[static_cast<std::size_t>(place)]; };
  const auto hang_pose = [&](Index pose, Index parent) {
    relations.poses[static_cast<std::size_t>(pose)].parent = parent;
    relations.order.push_back(pose);
  };
  for (const Index pose : join.held) hang_pose(pose, kWorld);
  const SpanningTree tree = spanning_tree(*join.system);
  for (const TreeEdge& edge : tree.poses) hang_pose(pose_at(edge.child), pose_at(edge.parent));
  for (const TreeEdge& edge : tree.features) {
    const Index feature = join.features[static_cast<std::size_t>(edge.child)];
    relations.features[static_cast<std::size_t>(feature)].parent = pose_at(edge.parent);
  }
  for (const auto& segment : segments) {
    for (const Index pose : segment.interior) hang_pose(pose, pose - 1);
  }
  for (const auto& map : network.maps) {
    for (const Index feature : map.private_features) {
      relations.features[static_cast<std::size_t>(feature)].parent = map.map.base;
    }
  }
}

}  // namespace

template <int Dim>
Relations<Dim> relations_of(const Network<Dim>& network, const Join<Dim>& join, const std::vector<Segment<Dim>>& segments,
                            const State<Dim>& state) {
  Relations<Dim> relations;
  relations.poses.resize(network.pose_count);
  relations.features.resize(network.feature_count);
  relations.order.reserve(network.pose_count);
  hang(network, join, segments, relations);
  for (std::size_t p = 0; p < network.pose_count; ++p) {
    PoseRelation<Dim>& relation = relations.poses[p];
    relation.placement = between(state.pose(relation.parent), state.poses[p]);
  }
  for (std::size_t f = 0; f < network.feature_count; ++f) {
    FeatureRelation<Dim>& relation = relations.features[f];
    relation.placement = transform_into(state.pose(relation.parent), state.features[f]);
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

#define MAPJOIN_INSTANTIATE(Dim)                                                                                \
  template Relations<Dim> relations_of(const Network<Dim>&, const Join<Dim>&, const std::vector<Segment<Dim>>&, \
                                       const State<Dim>&);                                                      \
  template State<Dim> composed(const Relations<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
