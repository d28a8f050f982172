// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cstdlib>
#include <mapjoin/join/spanning_tree.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A pose observed from a pose or the World: what may become an edge.
struct Relation {
  enum Rank { kChain, kClosure, kPrior } rank;
  Index base;
  Index target;
  std::size_t clique;
  std::size_t number;  // among the targets of its observation
};

/// In the order in which they are wanted.
template <int Dim>
std::vector<Relation> pose_relations(const JointSystem<Dim>& system) {
  std::vector<Relation> relations;
  std::size_t clique = 0;
  for (const auto& o : system.pose_observations()) {
    const bool is_chain = std::abs(o.target - o.base) == 1;
    const auto rank = o.base == kWorld ? Relation::kPrior : is_chain ? Relation::kChain : Relation::kClosure;
    relations.push_back({rank, o.base, o.target, clique++, 0});
  }
  clique += system.feature_observations().size();
  for (const auto& map : system.maps()) {
    const auto rank = map.base == kWorld ? Relation::kPrior : Relation::kChain;
    for (std::size_t p = 0; p < map.poses.size(); ++p) {
      relations.push_back({rank, map.base, map.poses[p], clique, p});
    }
    ++clique;
  }
  std::stable_sort(relations.begin(), relations.end(), [](const Relation& a, const Relation& b) { return a.rank < b.rank; });
  return relations;
}

/// Grows the tree from its roots outward.
template <int Dim>
class PoseTree {
 public:
  explicit PoseTree(const JointSystem<Dim>& system)
      : system_(system), edges_(system.estimate().poses.size() + 1), is_reached_(system.estimate().poses.size()) {
    choose(pose_relations(system));
  }

  std::vector<TreeEdge> grown() {
    for (std::size_t place = 0; place < is_reached_.size(); ++place) {
      if (system_.is_held(static_cast<Index>(place))) reach(static_cast<Index>(place));
    }
    grow();
    follow(kWorld);
    grow();
    for (std::size_t place = 0; place < is_reached_.size(); ++place) {
      if (is_reached_[place]) continue;
      tree_.push_back({static_cast<Index>(place), kWorld, std::nullopt});
      reach(static_cast<Index>(place));
      grow();
    }
    return std::move(tree_);
  }

 private:
  std::size_t node(Index place) const { return static_cast<std::size_t>(place + 1); }  // the World is the first

  /// Kruskal: every relation that ties together what was not yet. What is held is one with the World.
  void choose(const std::vector<Relation>& relations) {
    boost::disjoint_sets_with_storage<> parts(edges_.size());
    for (std::size_t place = 0; place < is_reached_.size(); ++place) {
      if (system_.is_held(static_cast<Index>(place))) parts.union_set(node(kWorld), node(static_cast<Index>(place)));
    }
    for (const Relation& relation : relations) {
      if (parts.find_set(node(relation.base)) == parts.find_set(node(relation.target))) continue;
      parts.union_set(node(relation.base), node(relation.target));
      for (const Index end : {relation.base, relation.target}) edges_[node(end)].push_back(relation);
    }
  }

  void reach(Index place) {
    is_reached_[static_cast<std::size_t>(place)] = true;
    front_.push_back(place);
  }

  /// Reaches what hangs from a pose or the World.
  void follow(Index parent) {
    for (const Relation& relation : edges_[node(parent)]) {
      const bool child_is_base = relation.target == parent;
      const Index child = child_is_base ? relation.base : relation.target;
      if (child == kWorld || is_reached_[static_cast<std::size_t>(child)]) continue;
      tree_.push_back({child, parent, TreeObservation{relation.clique, relation.number, child_is_base}});
      reach(child);
    }
  }

  void grow() {
    for (; grown_ < front_.size(); ++grown_) follow(front_[grown_]);
  }

  const JointSystem<Dim>& system_;
  std::vector<std::vector<Relation>> edges_;  // per node
  std::vector<bool> is_reached_;              // per pose
  std::vector<Index> front_;
  std::size_t grown_ = 0;
  std::vector<TreeEdge> tree_;
};

/// Each feature's first observation: that from the earliest pose; the World's only where there is no other.
template <int Dim>
std::vector<TreeEdge> feature_edges(const JointSystem<Dim>& system) {
  std::vector<TreeEdge> edges(system.estimate().features.size());
  for (std::size_t f = 0; f < edges.size(); ++f) edges[f].child = static_cast<Index>(f);
  const auto offer = [&](Index feature, Index base, std::size_t clique, std::size_t number) {
    TreeEdge& edge = edges[static_cast<std::size_t>(feature)];
    const bool is_earlier = !edge.observation || (base != kWorld && (edge.parent == kWorld || base < edge.parent));
    if (is_earlier) edge = {feature, base, TreeObservation{clique, number, false}};
  };
  std::size_t clique = system.pose_observations().size();
  for (const auto& o : system.feature_observations()) offer(o.target, o.base, clique++, 0);
  for (const auto& map : system.maps()) {
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      offer(map.features[f], map.base, clique, map.poses.size() + f);
    }
    ++clique;
  }
  return edges;
}

}  // namespace

template <int Dim>
SpanningTree spanning_tree(const JointSystem<Dim>& system) {
  return {PoseTree<Dim>(system).grown(), feature_edges(system)};
}

template SpanningTree spanning_tree(const JointSystem<2>&);
template SpanningTree spanning_tree(const JointSystem<3>&);

}  // namespace mapjoin
