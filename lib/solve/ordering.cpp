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

}  // namespace

std::vector<Index> elimination_order(const BlockGraph& graph) {
  if (graph.neighbours.empty()) {
    std::vector<Index> order(static_cast<std::size_t>(graph.size()));
    std::iota(order.begin(), order.end(), 0);
    return order;
  }
  const bool fits_metis = graph.neighbours.size() <= static_cast<std::size_t>(std::numeric_limits<idx_t>::max());
  return graph.size() < kSmall || !fits_metis ? minimum_degree(graph) : nested_dissection(graph);
}

}  // namespace mapjoin
