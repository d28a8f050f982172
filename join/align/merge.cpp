// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/range/iterator_range.hpp>
#include <iterator>
#include <limits>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/align/merge.hpp>
#include <mapjoin/join/align/placement.hpp>
#include <mapjoin/join/align/seam.hpp>
#include <optional>
#include <set>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
using Closures = std::vector<const PoseObservation<Dim>*>;

/// A pose or feature, and a piece that holds it.
using Holding = std::pair<Index, Vertex>;

/// What pieces hold, in order. `list` is their poses or their features.
template <int Dim>
std::vector<Holding> all_held(const std::vector<Piece<Dim>>& pieces, std::vector<Index> Piece<Dim>::*list) {
  std::vector<Holding> held;
  for (Vertex k = 0; k < pieces.size(); ++k) {
    for (const Index index : pieces[k].*list) held.emplace_back(index, k);
  }
  std::ranges::sort(held);
  return held;
}

/// The graph of submaps: an edge between every piece and each pose, feature and closure that several pieces share. The
/// vertices are the pieces, then what they share.
template <int Dim>
class SubmapGraph {
 public:
  SubmapGraph(const std::vector<Piece<Dim>>& pieces, const Closures<Dim>& closures)
      : vertices_(static_cast<Vertex>(pieces.size())), closures_(pieces.size()) {
    const std::vector<Holding> poses = all_held(pieces, &Piece<Dim>::poses);
    add_shared(poses);
    add_shared(all_held(pieces, &Piece<Dim>::features));
    for (const auto* closure : closures) add_closure(*closure, poses);
    graph_ = make_graph(vertices_, edges_);
    edges_.clear();
  }

  /// The closures at a piece.
  const Closures<Dim>& closures(Vertex piece) const { return closures_[piece]; }
  const Graph& graph() const { return graph_; }

 private:
  void add_shared(const std::vector<Holding>& held) {
    for (std::size_t k = 1; k < held.size(); ++k) {
      if (held[k].first != held[k - 1].first) continue;
      const bool is_known = k > 1 && held[k - 2].first == held[k].first;
      if (!is_known) edges_.emplace_back(vertices_++, held[k - 1].second);
      edges_.emplace_back(vertices_ - 1, held[k].second);
    }
  }

  void add_closure(const PoseObservation<Dim>& closure, const std::vector<Holding>& poses) {
    std::set<Vertex> ends;
    for (const Index pose : {closure.base, closure.target}) {
      auto held = std::lower_bound(poses.begin(), poses.end(), Holding{pose, 0});
      for (; held != poses.end() && held->first == pose; ++held) ends.insert(held->second);
    }
    for (const Vertex piece : ends) {
      edges_.emplace_back(vertices_, piece);
      closures_[piece].push_back(&closure);
    }
    ++vertices_;
  }

  Vertex vertices_;
  std::vector<Edge> edges_;
  std::vector<Closures<Dim>> closures_;  // per piece
  Graph graph_;
};

/// The placement of `b` in the frame of `a` that gives what ties them the least chi2, the first of equals; none where nothing
/// ties them.
template <int Dim>
std::optional<Pose<Dim>> placement_of(const Piece<Dim>& b, const Piece<Dim>& a, const Closures<Dim>& closures,
                                      bool tries_hypotheses) {
  const auto candidates = ties_between(a, b, closures).candidates();
  if (candidates.empty()) return std::nullopt;
  if (candidates.size() == 1 || !tries_hypotheses) return candidates.front();
  const Seam<Dim> seam(a, b, closures);
  return cheapest_placement<Dim>(candidates, [&](const Pose<Dim>& placement) { return seam.chi2(placement); });
}

/// Pieces of one frame that share nothing, merged.
template <int Dim>
Piece<Dim> united(std::span<Piece<Dim>> pieces) {
  if (pieces.size() == 1) return std::move(pieces.front());
  const std::size_t half = pieces.size() / 2;
  return merged(united(pieces.first(half)), united(pieces.subspan(half)), Pose<Dim>{});
}

/// Walks along the graph of submaps from one piece to what shares something with it.
template <int Dim>
class Merging {
 public:
  Merging(std::vector<Piece<Dim>> pieces, const Closures<Dim>& closures, bool tries_hypotheses)
      : pieces_(std::move(pieces)),
        submaps_(pieces_, closures),
        is_merged_(pieces_.size(), false),
        reached_from_(num_vertices(submaps_.graph()), kNone),
        tries_hypotheses_(tries_hypotheses) {}

  std::vector<Piece<Dim>> all() {
    std::vector<Piece<Dim>> all;
    for (Vertex first = 0; first < pieces_.size(); ++first) {
      if (!is_merged_[first]) all.push_back(grown_from(first));
    }
    return all;
  }

 private:
  static constexpr Vertex kNone = std::numeric_limits<Vertex>::max();

  Piece<Dim> grown_from(Vertex first) {
    Piece<Dim> grown = std::move(pieces_[first]);
    std::set<Vertex> neighbours;
    take(first, first, neighbours);
    add_leaves(grown, neighbours);
    while (!neighbours.empty()) {
      const Vertex next = neighbours.extract(neighbours.begin()).value();
      const auto placement = placement_in(grown, next);
      if (!placement) continue;
      grown = merged(grown, pieces_[next], *placement);
      take(next, first, neighbours);
      add_leaves(grown, neighbours);
    }
    return grown;
  }

  /// What a piece of the one that grows from `first` shares leads to its neighbours, unless it did before.
  void take(Vertex piece, Vertex first, std::set<Vertex>& neighbours) {
    is_merged_[piece] = true;
    for (const Vertex shared : in(piece)) {
      if (std::exchange(reached_from_[shared], first) == first) continue;
      for (const Vertex other : in(shared)) {
        if (other > first && !is_merged_[other]) neighbours.insert(other);
      }
    }
  }

  /// Neighbours that share nothing with any other: each has its place, whatever else is merged, and all are merged at once.
  void add_leaves(Piece<Dim>& grown, std::set<Vertex>& neighbours) {
    std::vector<Vertex> leaves;
    std::copy_if(neighbours.begin(), neighbours.end(), std::back_inserter(leaves), [&](Vertex v) { return is_leaf(v); });
    if (leaves.size() < 2) return;
    std::vector<Piece<Dim>> placed;
    for (const Vertex leaf : leaves) {
      neighbours.erase(leaf);
      const auto placement = placement_in(grown, leaf);
      if (!placement) continue;
      is_merged_[leaf] = true;
      placed.push_back(std::move(pieces_[leaf]));
      placed.back().state = moved(*placement, std::move(placed.back().state));
    }
    if (!placed.empty()) grown = merged(grown, united<Dim>(placed), Pose<Dim>{});
  }

  bool is_leaf(Vertex piece) const {
    for (const Vertex shared : in(piece)) {
      for (const Vertex other : in(shared)) {
        if (other != piece && !is_merged_[other]) return false;
      }
    }
    return true;
  }

  std::optional<Pose<Dim>> placement_in(const Piece<Dim>& grown, Vertex piece) const {
    return placement_of(pieces_[piece], grown, submaps_.closures(piece), tries_hypotheses_);
  }

  /// What a piece shares, or the pieces that share something.
  auto in(Vertex v) const { return boost::make_iterator_range(adjacent_vertices(v, submaps_.graph())); }

  std::vector<Piece<Dim>> pieces_;
  SubmapGraph<Dim> submaps_;
  std::vector<bool> is_merged_;       // per piece
  std::vector<Vertex> reached_from_;  // per vertex: the first piece of what reached it last
  bool tries_hypotheses_;
};

}  // namespace

template <int Dim>
std::vector<Piece<Dim>> merge_tied(std::vector<Piece<Dim>> pieces, const std::vector<const PoseObservation<Dim>*>& closures,
                                   bool tries_hypotheses) {
  if (pieces.size() != 2) return Merging<Dim>(std::move(pieces), closures, tries_hypotheses).all();
  const auto placement = placement_of(pieces[1], pieces[0], closures, tries_hypotheses);
  if (!placement) return pieces;
  return {merged(pieces[0], pieces[1], *placement)};
}

#define MAPJOIN_INSTANTIATE(Dim) \
  template std::vector<Piece<Dim>> merge_tied(std::vector<Piece<Dim>>, const Closures<Dim>&, bool);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
