// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/block_pattern.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Ascending lists of the values that gather(index, add) adds, each once; built on all threads.
template <typename Index, typename Gather>
Lists<Index, Index> sorted_lists(std::size_t count, Gather&& gather) {
  const std::size_t per_piece = std::max<std::size_t>(100, count / 64);
  std::vector<Lists<Index, Index>> pieces((count + per_piece - 1) / per_piece);
  parallel_chunks(count, per_piece, [&](std::size_t first, std::size_t last) {
    std::vector<Index> list;
    Table<Index, std::int32_t> added_to(count, -1);  // the last list that has each value
    for (const Index k : IndexRange<Index>{Index(first), Index(last)}) {
      list.clear();
      gather(k, [&](Index value) {
        if (std::exchange(added_to[value], k.value) != k.value) list.push_back(value);
      });
      std::sort(list.begin(), list.end());
      pieces[first / per_piece].push_back(list);
    }
  });
  Lists<Index, Index> lists;
  for (const auto& piece : pieces) lists.append(piece);
  return lists;
}

/// The factors of each variable.
class FactorsOf {
 public:
  explicit FactorsOf(const BlockPattern& pattern) : begin_(pattern.dofs.size() + 1, 0) {
    const auto& entries = pattern.factors.entries();
    for (const Variable v : entries) {
      if (v != kConstant) ++begin_[v + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    factors_.resize(begin_.back());
    Table<Variable, std::size_t> next(begin_.begin(), begin_.end());
    for (std::uint32_t f = 0; f < pattern.factors.size(); ++f) {
      for (const Variable v : pattern.factors[f]) {
        if (v != kConstant) factors_[next[v]++] = f;
      }
    }
  }
  std::span<const std::uint32_t> operator[](Variable v) const {
    return {factors_.data() + begin_[v], factors_.data() + begin_[v + 1]};
  }

 private:
  Table<Variable, std::size_t> begin_;
  std::vector<std::uint32_t> factors_;
};

}  // namespace

std::vector<bool> lone_ties(const BlockPattern& pattern) {
  static_assert(kConstant == -1, "what is held is the vertex before the first variable");
  const auto vertex = [](Variable v) { return static_cast<Vertex>((v + 1).position()); };
  std::vector<Edge> edges;
  std::vector<std::size_t> factors;  // of each edge
  for (std::size_t k = 0; k < pattern.factors.size(); ++k) {
    const auto variables = pattern.factors[k];
    for (const Variable v : variables.subspan(1)) {
      edges.emplace_back(vertex(variables.front()), vertex(v));
      factors.push_back(k);
    }
  }
  const std::vector<bool> is_bridge = bridges_of(1 + pattern.dofs.size(), edges);
  std::vector<bool> are_lone(pattern.factors.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (is_bridge[e]) are_lone[factors[e]] = true;
  }
  return are_lone;
}

Elimination::Elimination(const BlockPattern& pattern, const Ordering& ordering) {
  const FactorsOf factors_of(pattern);
  const std::size_t count = pattern.dofs.size();
  const BlockGraph graph = sorted_lists<Variable>(count, [&](Variable v, auto&& add) {
    for (const std::uint32_t factor : factors_of[v]) {
      for (const Variable other : pattern.factors[factor]) {
        if (other != kConstant && other != v) add(other);
      }
    }
  });
  order = elimination_order(graph, ordering);
  column = inverse_order(order);
  for (const Variable v : order) matrix.offsets.push_back(matrix.offsets.back() + pattern.dofs[v]);
  matrix.rows = sorted_lists<Column>(count, [&](Column k, auto&& add) {
    add(k);
    for (const Variable other : graph[order[k]]) {
      if (column[other] > k) add(column[other]);
    }
  });
}

}  // namespace mapjoin
