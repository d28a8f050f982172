// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sparse systems like those of maps: blocks of two and of three rows on a grid, ordered by nested dissection.

#include <algorithm>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {

/// The neighbours of each variable in a grid of `side` × `side`.
inline BlockGraph grid(int side) {
  BlockGraph graph;
  for (int v = 0; v < side * side; ++v) {
    std::vector<Variable> neighbours;
    if (v >= side) neighbours.emplace_back(v - side);
    if (v % side > 0) neighbours.emplace_back(v - 1);
    if (v % side + 1 < side) neighbours.emplace_back(v + 1);
    if (v + side < side * side) neighbours.emplace_back(v + side);
    graph.push_back(neighbours);
  }
  return graph;
}

/// A positive definite matrix with a block for each pair of neighbours in a grid, in an order of little fill.
inline BlockLower grid_system(int side, Random& random) {
  const BlockGraph graph = grid(side);
  const Table<Column, Variable> order = elimination_order(graph);
  const Table<Variable, Column> column = inverse_order(order);
  BlockLower A;
  for (const Variable v : order) A.offsets.push_back(A.offsets.back() + 2 + v.value % 2);
  for (const Column k : indices(order)) {
    std::vector<Column> rows{k};
    for (const Variable neighbour : graph[order[k]]) {
      if (column[neighbour] > k) rows.push_back(column[neighbour]);
    }
    std::sort(rows.begin(), rows.end());
    A.rows.push_back(rows);
  }
  A.lay_out();
  for (const Column k : A.columns()) {
    for (auto& entry : A.panel(k).reshaped()) entry = random.uniform(-1.0, 1.0);
    A.panel(k).diagonal().array() += 16.0;
  }
  return A;
}

/// The whole symmetric matrix, dense.
inline Eigen::MatrixXd dense(const BlockLower& A) {
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(A.size(), A.size());
  for (const Column k : A.columns()) {
    Eigen::Index row = 0;
    for (const Column i : A.rows[k]) {
      lower.block(A.offsets[i], A.offsets[k], A.dof(i), A.dof(k)) = A.panel(k).middleRows(row, A.dof(i));
      row += A.dof(i);
    }
  }
  return lower.selfadjointView<Eigen::Lower>();
}

}  // namespace mapjoin::testing
