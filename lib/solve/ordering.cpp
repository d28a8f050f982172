// SPDX-License-Identifier: BSD-3-Clause
#include <metis.h>
#include <suitesparse/amd.h>
#include <suitesparse/camd.h>

#include <algorithm>
#include <limits>
#include <mapjoin/solve/elimination_tree.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <mutex>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>

namespace mapjoin {
namespace {

/// Below this many variables minimum degree is as good as dissection and faster.
constexpr Index kSmall = 200;

/// AMD or, where variables come last, CAMD (Amestoy, Davis & Duff, 2004).
std::vector<Index> minimum_degree(const BlockGraph& graph, Index last_count) {
  std::vector<SuiteSparse_long> begin(graph.begin.begin(), graph.begin.end());
  std::vector<SuiteSparse_long> neighbours(graph.neighbours.begin(), graph.neighbours.end());
  std::vector<SuiteSparse_long> order(static_cast<std::size_t>(graph.size()));
  SuiteSparse_long status = AMD_OK;
  if (last_count == 0) {
    status = amd_l_order(graph.size(), begin.data(), neighbours.data(), order.data(), nullptr, nullptr);
  } else {
    std::vector<SuiteSparse_long> is_last(order.size(), 0);
    std::fill(is_last.end() - last_count, is_last.end(), 1);
    status = camd_l_order(graph.size(), begin.data(), neighbours.data(), order.data(), nullptr, nullptr, is_last.data());
  }
  if (status == AMD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (status < 0) throw std::runtime_error("AMD failed with status " + std::to_string(status));
  return {order.begin(), order.end()};
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

std::vector<Index> inverse_order(const std::vector<Index>& order) {
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  return place;
}

std::vector<Index> elimination_order(const BlockGraph& graph, const Ordering& ordering) {
  if (!ordering.given.empty()) return postordered(graph, ordering.given);
  if (graph.neighbours.empty()) {
    std::vector<Index> order(static_cast<std::size_t>(graph.size()));
    std::iota(order.begin(), order.end(), 0);
    return order;
  }
  const bool fits_metis = graph.neighbours.size() <= static_cast<std::size_t>(std::numeric_limits<idx_t>::max());
  const bool is_dissected = graph.size() >= kSmall && ordering.last_count == 0 && fits_metis;
  return postordered(graph, is_dissected ? nested_dissection(graph) : minimum_degree(graph, ordering.last_count));
}

}  // namespace mapjoin
