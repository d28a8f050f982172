// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A sparse system as maps make them: blocks of two and of three on a grid, ordered by dissection.

#include <algorithm>
#include <mapjoin/solve/ordering.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {

/// The neighbours of each variable in a grid of `side` × `side`.
inline BlockGraph grid(Index side) {
  BlockGraph graph{{0}, {}};
  for (Index v = 0; v < side * side; ++v) {
    if (v >= side) graph.neighbours.push_back(v - side);
    if (v % side > 0) graph.neighbours.push_back(v - 1);
    if (v % side + 1 < side) graph.neighbours.push_back(v + 1);
    if (v + side < side * side) graph.neighbours.push_back(v + side);
    graph.begin.push_back(static_cast<std::int64_t>(graph.neighbours.size()));
  }
  return graph;
}

/// Positive definite, with a block for each pair of neighbours in a grid, in an order of little fill.
inline BlockLower grid_system(Index side, Random& random) {
  const BlockGraph graph = grid(side);
  const std::vector<Index> order = elimination_order(graph);
  const std::vector<Index> place = inverse_order(order);
  BlockLower A;
  for (const Index v : order) A.offsets.push_back(A.offsets.back() + 2 + v % 2);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto v = static_cast<std::size_t>(order[k]);
    std::vector<Index> rows{static_cast<Index>(k)};
    for (auto n = graph.begin[v]; n < graph.begin[v + 1]; ++n) {
      const Index row = place[static_cast<std::size_t>(graph.neighbours[static_cast<std::size_t>(n)])];
      if (row > rows.front()) rows.push_back(row);
    }
    std::sort(rows.begin(), rows.end());
    A.append_column(rows);
  }
  A.lay_out();
  for (std::size_t k = 0; k < A.blocks(); ++k) {
    Eigen::Map<Eigen::MatrixXd> panel(A.values.data() + A.first_value[k], A.heights[k], A.dof(k));
    for (auto& entry : panel.reshaped()) entry = random.uniform(-1.0, 1.0);
    panel.diagonal().array() += 16.0;
  }
  return A;
}

/// The whole symmetric matrix.
inline Eigen::MatrixXd dense(const BlockLower& A) {
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(A.size(), A.size());
  for (std::size_t k = 0; k < A.blocks(); ++k) {
    const Eigen::Map<const Eigen::MatrixXd> panel(A.values.data() + A.first_value[k], A.heights[k], A.dof(k));
    Eigen::Index row = 0;
    for (const Index block : A.rows_of(k)) {
      const auto i = static_cast<std::size_t>(block);
      lower.block(A.offsets[i], A.offsets[k], A.dof(i), A.dof(k)) = panel.middleRows(row, A.dof(i));
      row += A.dof(i);
    }
  }
  return lower.selfadjointView<Eigen::Lower>();
}

}  // namespace mapjoin::testing
