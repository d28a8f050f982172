// SPDX-License-Identifier: BSD-3-Clause
#include <metis.h>
#include <suitesparse/amd.h>
#include <suitesparse/camd.h>

#include <algorithm>
#include <limits>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/cholmod.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <mutex>
#include <utility>

namespace mapjoin {
namespace {

/// The number of variables below which minimum degree is as good as dissection, and faster.
constexpr std::size_t kSmall = 200;

using Longs = std::vector<SuiteSparse_long>;

/// The numbers of typed indices.
template <typename Number, typename Index>
std::vector<Number> numbers(const std::vector<Index>& indices) {
  std::vector<Number> result;
  result.reserve(indices.size());
  for (const Index index : indices) result.push_back(index.value);
  return result;
}

template <typename Numbers>
Table<Column, Variable> variables(const Numbers& numbers) {
  Table<Column, Variable> result;
  result.reserve(numbers.size());
  for (const auto number : numbers) result.emplace_back(number);
  return result;
}

void check(int status, int out_of_memory, bool has_failed, const char* library) {
  if (status == out_of_memory) throw std::bad_alloc();
  if (has_failed) throw std::runtime_error(library + (" failed with status " + std::to_string(status)));
}

/// Ranks as CAMD takes them: from 0 on without gaps (with gaps it writes out of bounds).
Longs without_gaps(Longs ranks) {
  Longs distinct = ranks;
  make_distinct(distinct);
  for (auto& rank : ranks) rank = std::lower_bound(distinct.begin(), distinct.end(), rank) - distinct.begin();
  return ranks;
}

/// An order by AMD or, with ranks, CAMD (Amestoy, Davis & Duff, 2004).
Table<Column, Variable> minimum_degree(const BlockGraph& graph, const Table<Variable, int>& ranks) {
  const auto n = static_cast<SuiteSparse_long>(graph.size());
  const Longs begin(graph.begins().begin(), graph.begins().end());
  const auto neighbours = numbers<SuiteSparse_long>(graph.entries());
  Longs order(graph.size());
  auto constraints = without_gaps({ranks.begin(), ranks.end()});
  const auto status =
      ranks.empty() ? amd_l_order(n, begin.data(), neighbours.data(), order.data(), nullptr, nullptr)
                    : camd_l_order(n, begin.data(), neighbours.data(), order.data(), nullptr, nullptr, constraints.data());
  check(static_cast<int>(status), AMD_OUT_OF_MEMORY, status < 0, "AMD");
  return variables(order);
}

std::mutex metis_has_one_random_state;

Table<Column, Variable> nested_dissection(const BlockGraph& graph, const Table<Variable, int>& weights) {
  auto n = static_cast<idx_t>(graph.size());
  std::vector<idx_t> begin(graph.begins().begin(), graph.begins().end());
  auto neighbours = numbers<idx_t>(graph.entries());
  std::vector<idx_t> order(graph.size());
  std::vector<idx_t> place(graph.size());
  std::vector<idx_t> weighed(weights.begin(), weights.end());
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const std::lock_guard lock(metis_has_one_random_state);
  const int status = METIS_NodeND(&n, begin.data(), neighbours.data(), weighed.empty() ? nullptr : weighed.data(), options,
                                  order.data(), place.data());
  check(status, METIS_ERROR_MEMORY, status != METIS_OK, "METIS");
  return variables(order);
}

struct Analysis {
  Longs parent;
  Longs postorder;
  Longs counts;
};

/// CHOLMOD's analysis of one triangle of a pattern, eliminated in `order`, or in the natural one if that is empty.
Analysis analysed(Longs begin, Longs rows, Triangle triangle, Longs order) {
  const std::size_t n = begin.size() - 1;
  Analysis analysis{Longs(n), Longs(n), Longs(n)};
  Longs first(n);
  Longs level(n);
  cholmod_sparse matrix = sparse_view(begin, rows, nullptr, triangle);
  Cholmod cholmod;
  cholmod_l_analyze_ordering(&matrix, order.empty() ? CHOLMOD_NATURAL : CHOLMOD_GIVEN, order.data(), nullptr, 0,
                             analysis.parent.data(), analysis.postorder.data(), analysis.counts.data(), first.data(),
                             level.data(), cholmod.get());
  cholmod.check();
  return analysis;
}

/// The elimination order with every subtree in one run of columns: equal fill, and supernodes that are runs.
Table<Column, Variable> postordered(const BlockGraph& graph, const Table<Column, Variable>& order) {
  Longs begin{0};
  Longs rows;  // the smaller end of each edge, in the column of the larger one
  rows.reserve(graph.entries().size() / 2);
  for (Variable v = 0; v.position() < graph.size(); ++v) {
    for (const Variable neighbour : graph[v]) {
      if (neighbour < v) rows.push_back(neighbour.value);
    }
    begin.push_back(static_cast<SuiteSparse_long>(rows.size()));
  }
  const Analysis analysis = analysed(std::move(begin), std::move(rows), Triangle::kUpper, numbers<SuiteSparse_long>(order));
  Table<Column, Variable> result;
  result.reserve(order.size());
  for (const SuiteSparse_long column : analysis.postorder) result.push_back(order[Column(column)]);
  return result;
}

/// The graph of some of its variables, numbered by their places.
BlockGraph induced_graph(const BlockGraph& graph, const std::vector<Variable>& some) {
  Table<Variable, Variable> place(graph.size(), kConstant);
  for (std::size_t k = 0; k < some.size(); ++k) place[some[k]] = Variable(k);
  BlockGraph induced;
  std::vector<Variable> neighbours;
  for (const Variable v : some) {
    neighbours.clear();
    for (const Variable neighbour : graph[v]) {
      if (place[neighbour] != kConstant) neighbours.push_back(place[neighbour]);
    }
    induced.push_back(neighbours);
  }
  return induced;
}

/// An order of all variables but the border, then the border.
Table<Column, Variable> bordered_order(const BlockGraph& graph, const std::vector<Variable>& border,
                                       const Table<Variable, int>& weights) {
  Table<Variable, bool> is_inside(graph.size(), true);
  for (const Variable v : border) is_inside[v] = false;
  std::vector<Variable> inside;
  for (const Variable v : indices(is_inside)) {
    if (is_inside[v]) inside.push_back(v);
  }
  Ordering ordering;
  for (const Variable v : inside) {
    if (!weights.empty()) ordering.weights.push_back(weights[v]);
  }
  Table<Column, Variable> order = elimination_order(induced_graph(graph, inside), ordering);
  for (Variable& v : order) v = inside[v.position()];
  order.insert(order.end(), border.begin(), border.end());
  return order;
}

/// The variables that are not of the lowest rank, by rank.
std::vector<Variable> higher_ranked(const Table<Variable, int>& ranks) {
  const int lowest = *std::min_element(ranks.begin(), ranks.end());
  std::vector<Variable> higher;
  for (const Variable v : indices(ranks)) {
    if (ranks[v] > lowest) higher.push_back(v);
  }
  std::stable_sort(higher.begin(), higher.end(), [&](Variable a, Variable b) { return ranks[a] < ranks[b]; });
  return higher;
}

}  // namespace

Table<Variable, Column> inverse_order(const Table<Column, Variable>& order) {
  Table<Variable, Column> columns(order.size());
  for (const Column column : indices(order)) columns[order[column]] = column;
  return columns;
}

Table<Column, Variable> elimination_order(const BlockGraph& graph, const Ordering& ordering) {
  if (!ordering.border.empty() && !ordering.given.empty()) return ordering.given;
  if (!ordering.border.empty()) return bordered_order(graph, ordering.border, ordering.weights);
  if (!ordering.given.empty()) return postordered(graph, ordering.given);
  if (graph.entries().empty()) {
    const IndexRange<Variable> all{0, Variable(graph.size())};
    return {all.begin(), all.end()};
  }
  const bool fits_metis = graph.entries().size() <= static_cast<std::size_t>(std::numeric_limits<idx_t>::max());
  if (!fits_metis || graph.size() < kSmall) {
    return postordered(graph, minimum_degree(graph, ordering.ranks));
  }
  return postordered(graph, ordering.ranks.empty() ? nested_dissection(graph, ordering.weights)
                                                   : bordered_order(graph, higher_ranked(ordering.ranks), ordering.weights));
}

Table<Variable, std::int32_t> partition(const BlockGraph& graph, const Table<Variable, std::int32_t>& weights,
                                        std::int32_t parts) {
  auto n = static_cast<idx_t>(graph.size());
  auto count = static_cast<idx_t>(parts);
  Table<Variable, std::int32_t> part(graph.size(), 0);
  if (count == 1 || n == 0) return part;
  idx_t constraints = 1;
  idx_t cut = 0;
  std::vector<idx_t> begin(graph.begins().begin(), graph.begins().end());
  auto neighbours = numbers<idx_t>(graph.entries());
  std::vector<idx_t> weighed(weights.begin(), weights.end());
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  const std::lock_guard lock(metis_has_one_random_state);
  const int status = METIS_PartGraphRecursive(&n, &constraints, begin.data(), neighbours.data(), weighed.data(), nullptr,
                                              nullptr, &count, nullptr, nullptr, options, &cut, part.data());
  check(status, METIS_ERROR_MEMORY, status != METIS_OK, "METIS");
  return part;
}

EliminationTree elimination_tree(const BlockLower& matrix) {
  if (matrix.rows.size() == 0) return {};
  const auto& begins = matrix.rows.begins();
  const Analysis analysis =
      analysed({begins.begin(), begins.end()}, numbers<SuiteSparse_long>(matrix.rows.entries()), Triangle::kLower, {});
  EliminationTree tree;
  const Column end(matrix.rows.size());
  for (const SuiteSparse_long parent : analysis.parent) tree.parent.push_back(parent < 0 ? end : Column(parent));
  tree.counts.assign(analysis.counts.begin(), analysis.counts.end());
  return tree;
}

}  // namespace mapjoin
