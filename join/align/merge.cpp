// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/range/iterator_range.hpp>
#include <iterator>
#include <limits>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/shared_factors.hpp>
#include <optional>
#include <set>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
using Closures = std::vector<const PoseFactor<Dim>*>;

/// A pose or feature, and a partial map that holds it.
template <typename Index>
using Holding = std::pair<Index, Vertex>;

/// All poses or all features, by `list`, that partial maps hold, ascending.
template <int Dim, typename Index>
std::vector<Holding<Index>> all_held(const std::vector<PartialMap<Dim>>& partials, Table<Index, Index> PartialMap<Dim>::*list) {
  std::vector<Holding<Index>> held;
  for (Vertex k = 0; k < partials.size(); ++k) {
    for (const Index index : partials[k].*list) held.emplace_back(index, k);
  }
  std::ranges::sort(held);
  return held;
}

/// The graph of submaps: an edge between every partial map and each pose, feature and closure that several partial maps share.
/// Its vertices are the partial maps, then the shared poses, features and closures.
template <int Dim>
class SharingGraph {
 public:
  SharingGraph(const std::vector<PartialMap<Dim>>& partials, const Closures<Dim>& closures)
      : vertices_(static_cast<Vertex>(partials.size())), closures_(partials.size()) {
    const std::vector<Holding<PoseIndex>> poses = all_held(partials, &PartialMap<Dim>::poses);
    add_shared(poses);
    add_shared(all_held(partials, &PartialMap<Dim>::features));
    for (const auto* closure : closures) add_closure(*closure, poses);
    graph_ = make_graph(vertices_, edges_);
    edges_.clear();
  }

  /// The closures at a partial map.
  const Closures<Dim>& closures(Vertex partial) const { return closures_[partial]; }
  const Graph& graph() const { return graph_; }

 private:
  template <typename Index>
  void add_shared(const std::vector<Holding<Index>>& held) {
    for (std::size_t k = 1; k < held.size(); ++k) {
      if (held[k].first != held[k - 1].first) continue;
      const bool is_known = k > 1 && held[k - 2].first == held[k].first;
      if (!is_known) edges_.emplace_back(vertices_++, held[k - 1].second);
      edges_.emplace_back(vertices_ - 1, held[k].second);
    }
  }

  void add_closure(const PoseFactor<Dim>& closure, const std::vector<Holding<PoseIndex>>& poses) {
    std::set<Vertex> ends;
    for (const PoseIndex pose : {closure.base, closure.target}) {
      auto held = std::lower_bound(poses.begin(), poses.end(), Holding<PoseIndex>{pose, 0});
      for (; held != poses.end() && held->first == pose; ++held) ends.insert(held->second);
    }
    for (const Vertex partial : ends) {
      edges_.emplace_back(vertices_, partial);
      closures_[partial].push_back(&closure);
    }
    ++vertices_;
  }

  Vertex vertices_;
  std::vector<Edge> edges_;
  std::vector<Closures<Dim>> closures_;  // per partial map
  Graph graph_;
};

/// The alignment of `b` in the frame of `a` with the least chi2 of their shared factors, the first of equals, or without
/// `tries_hypotheses` the first of all; nullopt if nothing determines one.
template <int Dim>
std::optional<Pose<Dim>> alignment_of(const PartialMap<Dim>& b, const PartialMap<Dim>& a, const Closures<Dim>& closures,
                                      bool tries_hypotheses) {
  const auto candidates = correspondences_between(a, b, closures).candidates();
  if (candidates.empty()) return std::nullopt;
  if (candidates.size() == 1 || !tries_hypotheses) return candidates.front();
  const SharedFactors<Dim> shared(a, b, closures);
  return cheapest_alignment<Dim>(candidates, [&](const Pose<Dim>& alignment) { return shared.chi2(alignment); });
}

/// The union of partial maps in one frame that share nothing.
template <int Dim>
PartialMap<Dim> united(std::span<PartialMap<Dim>> partials) {
  if (partials.size() == 1) return std::move(partials.front());
  const std::size_t half = partials.size() / 2;
  return merged(united(partials.first(half)), united(partials.subspan(half)), Pose<Dim>{});
}

/// Merges partial maps along the graph of submaps, from each to those that share something with it.
template <int Dim>
class Merging {
 public:
  Merging(std::vector<PartialMap<Dim>> partials, const Closures<Dim>& closures, bool tries_hypotheses)
      : partials_(std::move(partials)),
        submaps_(partials_, closures),
        is_merged_(partials_.size(), false),
        reached_from_(num_vertices(submaps_.graph()), kNone),
        tries_hypotheses_(tries_hypotheses) {}

  std::vector<PartialMap<Dim>> all() {
    std::vector<PartialMap<Dim>> all;
    for (Vertex first = 0; first < partials_.size(); ++first) {
      if (!is_merged_[first]) all.push_back(grown_from(first));
    }
    return all;
  }

 private:
  static constexpr Vertex kNone = std::numeric_limits<Vertex>::max();

  PartialMap<Dim> grown_from(Vertex first) {
    PartialMap<Dim> grown = std::move(partials_[first]);
    std::set<Vertex> neighbours;
    take(first, first, neighbours);
    add_leaves(grown, neighbours);
    while (!neighbours.empty()) {
      const Vertex next = neighbours.extract(neighbours.begin()).value();
      const auto alignment = alignment_in(grown, next);
      if (!alignment) continue;
      grown = merged(grown, partials_[next], *alignment);
      take(next, first, neighbours);
      add_leaves(grown, neighbours);
    }
    return grown;
  }

  /// Marks a partial map as merged into the one that grows from `first`, and adds those that share something with it to
  /// `neighbours`.
  void take(Vertex partial, Vertex first, std::set<Vertex>& neighbours) {
    is_merged_[partial] = true;
    for (const Vertex shared : in(partial)) {
      if (std::exchange(reached_from_[shared], first) == first) continue;
      for (const Vertex other : in(shared)) {
        if (!is_merged_[other]) neighbours.insert(other);
      }
    }
  }

  /// Merges all neighbours at once that share nothing with any other: their alignment does not depend on further merges.
  void add_leaves(PartialMap<Dim>& grown, std::set<Vertex>& neighbours) {
    std::vector<Vertex> leaves;
    std::copy_if(neighbours.begin(), neighbours.end(), std::back_inserter(leaves), [&](Vertex v) { return is_leaf(v); });
    if (leaves.size() < 2) return;
    std::vector<PartialMap<Dim>> placed;
    for (const Vertex leaf : leaves) {
      neighbours.erase(leaf);
      const auto alignment = alignment_in(grown, leaf);
      if (!alignment) continue;
      is_merged_[leaf] = true;
      placed.push_back(std::move(partials_[leaf]));
      placed.back().state = moved(*alignment, std::move(placed.back().state));
    }
    if (!placed.empty()) grown = merged(grown, united<Dim>(placed), Pose<Dim>{});
  }

  bool is_leaf(Vertex partial) const {
    for (const Vertex shared : in(partial)) {
      for (const Vertex other : in(shared)) {
        if (other != partial && !is_merged_[other]) return false;
      }
    }
    return true;
  }

  std::optional<Pose<Dim>> alignment_in(const PartialMap<Dim>& grown, Vertex partial) const {
    return alignment_of(partials_[partial], grown, submaps_.closures(partial), tries_hypotheses_);
  }

  /// The shared vertices of a partial map, or the partial maps of a shared vertex.
  auto in(Vertex v) const { return boost::make_iterator_range(adjacent_vertices(v, submaps_.graph())); }

  std::vector<PartialMap<Dim>> partials_;
  SharingGraph<Dim> submaps_;
  std::vector<bool> is_merged_;       // per partial map
  std::vector<Vertex> reached_from_;  // per vertex: the first partial map of the merged one that reached it last
  bool tries_hypotheses_;
};

}  // namespace

template <int Dim>
std::vector<PartialMap<Dim>> merge_tied(std::vector<PartialMap<Dim>> partials,
                                        const std::vector<const PoseFactor<Dim>*>& closures, bool tries_hypotheses) {
  // A partial map that shared too few features with one that grew may by now share more with another.
  for (std::size_t before = partials.size() + 1; partials.size() > 2 && partials.size() < before;) {
    before = partials.size();
    partials = Merging<Dim>(std::move(partials), closures, tries_hypotheses).all();
  }
  if (partials.size() != 2) return partials;
  const auto alignment = alignment_of(partials[1], partials[0], closures, tries_hypotheses);
  if (!alignment) return partials;
  return {merged(partials[0], partials[1], *alignment)};
}

#define MAPJOIN_INSTANTIATE(Dim) \
  template std::vector<PartialMap<Dim>> merge_tied(std::vector<PartialMap<Dim>>, const Closures<Dim>&, bool);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
