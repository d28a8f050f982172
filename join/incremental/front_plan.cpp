// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <mapjoin/join/incremental/front_plan.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// A front this small costs no more than its bookkeeping, however many zeros it holds.
constexpr int kSmallFront = 24;
/// The share of a front's rows that may be zero for a variable that is merged into it.
constexpr double kZeroRows = 0.1;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

/// The neighbours of each of the first `count` variables among themselves.
BlockGraph graph_of(Index count, const Cliques& cliques) {
  std::vector<std::vector<Index>> cliques_of(at(count));
  for (std::size_t c = 0; c < cliques.size(); ++c) {
    for (const Index v : cliques[c]) {
      if (v < count) cliques_of[at(v)].push_back(static_cast<Index>(c));
    }
  }
  BlockGraph graph{{0}, {}};
  std::vector<Index> met_by(at(count), -1);
  for (Index v = 0; v < count; ++v) {
    met_by[at(v)] = v;
    for (const Index c : cliques_of[at(v)]) {
      for (const Index w : cliques[at(c)]) {
        if (w >= count || met_by[at(w)] == v) continue;
        met_by[at(w)] = v;
        graph.neighbours.push_back(w);
      }
    }
    graph.begin.push_back(static_cast<std::int64_t>(graph.neighbours.size()));
  }
  return graph;
}

/// Variables by their place. Those that come last need no part in the graph: they change nothing in the fill of the others.
std::vector<Index> order_of(Index count, const Cliques& cliques, Index last_count) {
  std::vector<Index> order = elimination_order(graph_of(count - last_count, cliques));
  for (Index v = count - last_count; v < count; ++v) order.push_back(v);
  return order;
}

/// What each place's elimination ties together: places after it, ascending.
std::vector<std::vector<Index>> structure_of(const std::vector<Index>& place, const Cliques& cliques,
                                             const std::vector<Index>& first_places) {
  const std::size_t count = place.size();
  std::vector<std::vector<Index>> starting(count);  // cliques by their first place
  for (std::size_t c = 0; c < cliques.size(); ++c) starting[at(first_places[c])].push_back(static_cast<Index>(c));
  std::vector<std::vector<Index>> structure(count);
  std::vector<std::vector<Index>> children(count);
  std::vector<std::size_t> met_by(count, count);
  for (std::size_t i = 0; i < count; ++i) {
    met_by[i] = i;
    const auto meet = [&](Index other) {
      if (met_by[at(other)] == i) return;
      met_by[at(other)] = i;
      structure[i].push_back(other);
    };
    for (const Index c : starting[i]) {
      for (const Index v : cliques[at(c)]) meet(place[at(v)]);
    }
    for (const Index child : children[i]) {
      for (const Index other : structure[at(child)]) meet(other);
    }
    std::sort(structure[i].begin(), structure[i].end());
    if (!structure[i].empty()) children[at(structure[i].front())].push_back(static_cast<Index>(i));
  }
  return structure;
}

/// Whether a variable whose rows are `rows` may join a front of `size` rows, all of which then count for it.
bool is_worth_merging(int rows, int size, int dof) {
  return size + dof <= kSmallFront || size - rows <= kZeroRows * size;
}

}  // namespace

FrontPlan plan_fronts(const std::vector<int>& dofs, const Cliques& cliques, Index last_count) {
  const auto count = static_cast<Index>(dofs.size());
  const std::vector<Index> order = order_of(count, cliques, last_count);
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[at(order[i])] = static_cast<Index>(i);
  std::vector<Index> first_places;
  for (std::size_t c = 0; c < cliques.size(); ++c) {
    Index first = std::numeric_limits<Index>::max();
    for (const Index v : cliques[c]) first = std::min(first, place[at(v)]);
    first_places.push_back(first);
  }
  const auto structure = structure_of(place, cliques, first_places);

  FrontPlan plan;
  std::vector<int> sizes;  // rows of each front
  std::vector<Index> front_of(order.size());
  for (Index i = count - 1; i >= 0; --i) {
    const int dof = dofs[at(order[at(i)])];
    int rows = 0;
    for (const Index other : structure[at(i)]) rows += dofs[at(order[at(other)])];
    const Index parent = structure[at(i)].empty() ? -1 : front_of[at(structure[at(i)].front())];
    if (parent >= 0 && is_worth_merging(rows, sizes[at(parent)], dof)) {
      front_of[at(i)] = parent;
      plan.fronts[at(parent)].frontals.push_back(order[at(i)]);
      sizes[at(parent)] += dof;
      continue;
    }
    front_of[at(i)] = static_cast<Index>(plan.fronts.size());
    PlannedFront& front = plan.fronts.emplace_back(PlannedFront{{order[at(i)]}, {}, parent});
    for (const Index other : structure[at(i)]) front.separator.push_back(order[at(other)]);
    sizes.push_back(rows + dof);
  }
  for (const Index first : first_places) plan.front_of_clique.push_back(front_of[at(first)]);
  return plan;
}

}  // namespace mapjoin
