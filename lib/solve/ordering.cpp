// SPDX-License-Identifier: BSD-3-Clause
#include <metis.h>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <limits>
#include <mapjoin/solve/ordering.hpp>
#include <mutex>
#include <new>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// Below this many variables minimum degree is as good as dissection and faster.
constexpr Index kSmall = 200;

std::vector<Index> minimum_degree(const BlockGraph& graph) {
  Eigen::SparseMatrix<double, Eigen::ColMajor, Index> A(graph.size(), graph.size());
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(graph.neighbours.size() + graph.begin.size());
  for (Index v = 0; v < graph.size(); ++v) {
    entries.emplace_back(v, v, 1.0);
    for (auto k = graph.begin[static_cast<std::size_t>(v)]; k < graph.begin[static_cast<std::size_t>(v) + 1]; ++k) {
      entries.emplace_back(graph.neighbours[static_cast<std::size_t>(k)], v, 1.0);
    }
  }
  A.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> permutation;
  Eigen::AMDOrdering<Index>()(A, permutation);
  const auto& indices = permutation.indices();
  return {indices.data(), indices.data() + indices.size()};
}

std::vector<Index> nested_dissection(const BlockGraph& graph) {
  static std::mutex metis_has_one_random_state;
  idx_t n = graph.size();
  std::vector<idx_t> begin(graph.begin.begin(), graph.begin.end());
  std::vector<idx_t> neighbours(graph.neighbours.begin(), graph.neighbours.end());
  std::vector<idx_t> order(static_cast<std::size_t>(n));
  std::vector<idx_t> place(static_cast<std::size_t>(n));
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const std::lock_guard lock(metis_has_one_random_state);
  const int status = METIS_NodeND(&n, begin.data(), neighbours.data(), nullptr, options, order.data(), place.data());
  if (status == METIS_ERROR_MEMORY) throw std::bad_alloc();
  if (status != METIS_OK) throw std::runtime_error("METIS failed with status " + std::to_string(status));
  return {order.begin(), order.end()};
}

/// Per place of the elimination, the place that it is first coupled to once it is eliminated; the size for a root (Liu, 1986).
std::vector<Index> elimination_tree(const BlockGraph& graph, const std::vector<Index>& order) {
  const std::vector<Index> place = inverse_order(order);
  std::vector<Index> parent(order.size(), graph.size());
  std::vector<Index> ancestor(order.size(), graph.size());  // a shortcut towards the root
  for (Index k = 0; k < graph.size(); ++k) {
    const auto v = static_cast<std::size_t>(order[static_cast<std::size_t>(k)]);
    for (auto n = graph.begin[v]; n < graph.begin[v + 1]; ++n) {
      Index i = place[static_cast<std::size_t>(graph.neighbours[static_cast<std::size_t>(n)])];
      while (i < k) {
        const auto at = static_cast<std::size_t>(i);
        i = std::exchange(ancestor[at], k);
        if (i == graph.size()) parent[at] = k;
      }
    }
  }
  return parent;
}

}  // namespace

std::vector<Index> postordered(const BlockGraph& graph, const std::vector<Index>& order) {
  const std::vector<Index> parent = elimination_tree(graph, order);
  // How many places the subtrees of each place take, then where they begin: children of one parent by their places.
  std::vector<Index> taken(order.size(), 1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (parent[k] < graph.size()) taken[static_cast<std::size_t>(parent[k])] += taken[k];
  }
  std::vector<Index> next(order.size() + 1, 0);  // the first free place below each parent, the last one for roots
  std::vector<Index> result(order.size());
  for (std::size_t k = order.size(); k-- > 0;) {
    Index& free = next[static_cast<std::size_t>(parent[k])];
    const Index first = free;
    free += taken[k];
    next[k] = first;
    result[static_cast<std::size_t>(first + taken[k] - 1)] = order[k];
  }
  return result;
}

std::vector<Index> inverse_order(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  return place;
}

std::vector<Index> elimination_order(const BlockGraph& graph) {
  if (graph.neighbours.empty()) {
    std::vector<Index> order(static_cast<std::size_t>(graph.size()));
    std::iota(order.begin(), order.end(), 0);
    return order;
  }
  const bool fits_metis = graph.neighbours.size() <= static_cast<std::size_t>(std::numeric_limits<idx_t>::max());
  return postordered(graph, graph.size() < kSmall || !fits_metis ? minimum_degree(graph) : nested_dissection(graph));
}

}  // namespace mapjoin
