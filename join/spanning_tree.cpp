// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdlib>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/spanning_tree.hpp>

namespace mapjoin {
namespace {

/// A pose observed from a pose or the World: a candidate for an edge.
struct Relation {
  enum Rank { kChain, kClosure, kPrior } rank;
  PoseIndex base;
  PoseIndex target;
  std::size_t factor;
  std::size_t number;  // among the targets of its observation
};

/// The relations of poses in the order of preference, without observations that do not measure a rotation.
template <int Dim>
std::vector<Relation> pose_relations(const JoiningSystem<Dim>& system) {
  std::vector<Relation> relations;
  std::size_t factor = 0;
  for (const auto& o : system.pose_factors()) {
    const bool is_chain = std::abs(o.target - o.base) == 1;
    const auto rank = o.base == kWorld ? Relation::kPrior : is_chain ? Relation::kChain : Relation::kClosure;
    if (measures_rotation(*o.observation)) relations.push_back({rank, o.base, o.target, factor, 0});
    ++factor;
  }
  factor += system.feature_factors().size();
  for (const auto& map : system.maps()) {
    const auto rank = map.base == kWorld ? Relation::kPrior : Relation::kChain;
    for (std::size_t p = 0; p < map.poses.size(); ++p) {
      relations.push_back({rank, map.base, map.poses[p], factor, p});
    }
    ++factor;
  }
  std::ranges::stable_sort(relations, {}, &Relation::rank);
  return relations;
}

/// The edge by which a pose was reached; `relation` is null if the pose is the root of a tree beside that of the World.
TreeEdge<PoseIndex> edge_of(PoseIndex pose, const Relation* relation) {
  if (!relation) return {pose, kWorld, std::nullopt};
  const bool child_is_base = relation->base == pose;
  return {pose, child_is_base ? relation->target : relation->base,
          TreeObservation{relation->factor, relation->number, child_is_base}};
}

/// The spanning forest of the relations, breadth first from the World, which stands for all anchored poses.
template <int Dim>
std::vector<TreeEdge<PoseIndex>> pose_edges(const JoiningSystem<Dim>& system) {
  constexpr Vertex kWorldVertex = 0;
  const auto vertex = [&](PoseIndex place) {
    return system.is_anchored(place) ? kWorldVertex : static_cast<Vertex>(1 + place.value);
  };
  const std::vector<Relation> relations = pose_relations(system);
  std::vector<Edge> edges;
  for (const Relation& relation : relations) edges.emplace_back(vertex(relation.base), vertex(relation.target));
  std::vector<Vertex> roots{kWorldVertex};
  for (const PoseIndex place : indices(system.estimate().poses)) roots.push_back(vertex(place));

  std::vector<TreeEdge<PoseIndex>> tree;
  for (const auto& [v, edge] : spanning_forest(1 + system.estimate().poses.size(), edges, roots)) {
    if (v != kWorldVertex) tree.push_back(edge_of(PoseIndex(v - 1), edge ? &relations[*edge] : nullptr));
  }
  return tree;
}

/// The edge of each feature: its observation from the earliest pose, or from the World if there is no other.
template <int Dim>
Table<FeatureIndex, TreeEdge<FeatureIndex>> feature_edges(const JoiningSystem<Dim>& system) {
  Table<FeatureIndex, TreeEdge<FeatureIndex>> edges(system.estimate().features.size());
  for (const FeatureIndex f : indices(edges)) edges[f].child = f;
  const auto offer = [&](FeatureIndex feature, PoseIndex base, std::size_t factor, std::size_t number) {
    auto& edge = edges[feature];
    const bool is_earlier = !edge.observation || (base != kWorld && (edge.parent == kWorld || base < edge.parent));
    if (is_earlier) edge = {feature, base, TreeObservation{factor, number, false}};
  };
  std::size_t factor = system.pose_factors().size();
  for (const auto& o : system.feature_factors()) offer(o.target, o.base, factor++, 0);
  for (const auto& map : system.maps()) {
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      offer(map.features[f], map.base, factor, map.poses.size() + f);
    }
    ++factor;
  }
  return edges;
}

}  // namespace

template <int Dim>
SpanningTree spanning_tree(const JoiningSystem<Dim>& system) {
  return {pose_edges(system), feature_edges(system)};
}

template <int Dim>
Measured<Pose<Dim>, kPoseDof<Dim>> measured_pose(const JoiningSystem<Dim>& system, const TreeObservation& observation) {
  constexpr int kDof = kPoseDof<Dim>;
  const auto [kind, place] = system.source_of(observation.factor);
  if (kind != JoiningSystem<Dim>::Source::kMap) {
    const auto& o = *system.pose_factors()[place].observation;
    return {o.measured, o.information};
  }
  const LocalMap<Dim>& map = *system.maps()[place].map;
  const Eigen::Index row = map.row(observation.target);
  return {map.pose_estimates[observation.target], map.information.template block<kDof, kDof>(row, row)};
}

template <int Dim>
Measured<Point<Dim>, Dim> measured_point(const JoiningSystem<Dim>& system, const TreeObservation& observation) {
  const auto [kind, place] = system.source_of(observation.factor);
  if (kind != JoiningSystem<Dim>::Source::kMap) {
    const auto& o = *system.feature_factors()[place].observation;
    return {o.measured, o.information};
  }
  const LocalMap<Dim>& map = *system.maps()[place].map;
  const Eigen::Index row = map.row(observation.target);
  return {map.feature_estimates[observation.target - map.poses.size()], map.information.template block<Dim, Dim>(row, row)};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                \
  template SpanningTree spanning_tree(const JoiningSystem<Dim>&);                                               \
  template Measured<Pose<Dim>, kPoseDof<Dim>> measured_pose(const JoiningSystem<Dim>&, const TreeObservation&); \
  template Measured<Point<Dim>, Dim> measured_point(const JoiningSystem<Dim>&, const TreeObservation&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
