// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/cholmod.hpp>
#include <mapjoin/solve/elimination_tree.hpp>

namespace mapjoin {
namespace {

/// One triangle of a symmetric pattern, by columns, ascending or not.
struct Triangle {
  std::vector<SuiteSparse_long> begin;
  std::vector<SuiteSparse_long> rows;
  int stype;  ///< 1: upper, -1: lower.

  cholmod_sparse view() {
    cholmod_sparse sparse{};
    sparse.nrow = sparse.ncol = begin.size() - 1;
    sparse.nzmax = rows.size();
    sparse.p = begin.data();
    sparse.i = rows.data();
    sparse.stype = stype;
    sparse.itype = CHOLMOD_LONG;
    sparse.xtype = CHOLMOD_PATTERN;
    sparse.dtype = CHOLMOD_DOUBLE;
    sparse.packed = 1;
    return sparse;
  }
};

struct Analysis {
  std::vector<SuiteSparse_long> parent;
  std::vector<SuiteSparse_long> postorder;
  std::vector<SuiteSparse_long> counts;
};

/// The elimination in `order`, or in the natural one where that is empty.
Analysis analysed(Triangle pattern, std::vector<SuiteSparse_long> order) {
  const std::size_t n = pattern.begin.size() - 1;
  Analysis analysis{std::vector<SuiteSparse_long>(n), std::vector<SuiteSparse_long>(n), std::vector<SuiteSparse_long>(n)};
  std::vector<SuiteSparse_long> first(n);
  std::vector<SuiteSparse_long> level(n);
  cholmod_sparse matrix = pattern.view();
  Cholmod cholmod;
  cholmod_l_analyze_ordering(&matrix, order.empty() ? CHOLMOD_NATURAL : CHOLMOD_GIVEN, order.data(), nullptr, 0,
                             analysis.parent.data(), analysis.postorder.data(), analysis.counts.data(), first.data(),
                             level.data(), cholmod.get());
  cholmod.check();
  return analysis;
}

/// Of each edge, the end at the column of the larger number.
Triangle upper_triangle(const BlockGraph& graph) {
  Triangle upper{{0}, {}, 1};
  upper.rows.reserve(graph.neighbours.size() / 2);
  for (Index v = 0; v < graph.size(); ++v) {
    for (auto n = graph.begin[static_cast<std::size_t>(v)]; n < graph.begin[static_cast<std::size_t>(v) + 1]; ++n) {
      const Index neighbour = graph.neighbours[static_cast<std::size_t>(n)];
      if (neighbour < v) upper.rows.push_back(neighbour);
    }
    upper.begin.push_back(static_cast<SuiteSparse_long>(upper.rows.size()));
  }
  return upper;
}

}  // namespace

EliminationTree elimination_tree(const BlockLower& matrix) {
  if (matrix.blocks() == 0) return {};
  const Analysis analysis =
      analysed({{matrix.begin.begin(), matrix.begin.end()}, {matrix.rows.begin(), matrix.rows.end()}, -1}, {});
  EliminationTree tree;
  for (const SuiteSparse_long parent : analysis.parent) {
    tree.parent.push_back(parent < 0 ? static_cast<Index>(matrix.blocks()) : static_cast<Index>(parent));
  }
  tree.counts.assign(analysis.counts.begin(), analysis.counts.end());
  return tree;
}

std::vector<Index> postordered(const BlockGraph& graph, const std::vector<Index>& order) {
  const Analysis analysis = analysed(upper_triangle(graph), {order.begin(), order.end()});
  std::vector<Index> result;
  result.reserve(order.size());
  for (const SuiteSparse_long place : analysis.postorder) result.push_back(order[static_cast<std::size_t>(place)]);
  return result;
}

}  // namespace mapjoin
