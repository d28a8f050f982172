// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small dense matrices in the storage of the sparse Cholesky factorisation, and its factor as a dense one.

#include <mapjoin/solve/engines/sparse_cholesky.hpp>

namespace mapjoin::testing {

/// A dense matrix in blocks of the sizes `dofs`, without its zero blocks. Entries above the diagonal of diagonal blocks, which
/// are to be ignored, are 1e9.
inline BlockLower sparse(const Eigen::MatrixXd& dense, const std::vector<Eigen::Index>& dofs) {
  BlockLower matrix;
  for (const Eigen::Index dof : dofs) matrix.offsets.push_back(matrix.offsets.back() + dof);
  const IndexRange<Column> columns{0, Column(dofs.size())};
  const auto block = [&](Column i, Column j) {
    return dense.block(matrix.offsets[i], matrix.offsets[j], matrix.dof(i), matrix.dof(j));
  };
  for (const Column j : columns) {
    std::vector<Column> rows;
    for (const Column i : IndexRange<Column>{j, columns.last}) {
      if (i == j || !block(i, j).isZero(0.0)) rows.push_back(i);
    }
    matrix.rows.push_back(rows);
  }
  matrix.lay_out();
  for (const Column j : columns) {
    auto panel = matrix.panel(j);
    Eigen::Index row = 0;
    for (const Column i : matrix.rows[j]) {
      panel.middleRows(row, matrix.dof(i)) = block(i, j);
      row += matrix.dof(i);
    }
    panel.topRows(matrix.dof(j)).triangularView<Eigen::StrictlyUpper>().fill(1e9);
  }
  return matrix;
}

/// A dense matrix in blocks of one entry, without its zeros.
inline BlockLower sparse(const Eigen::MatrixXd& dense) {
  return sparse(dense, std::vector<Eigen::Index>(static_cast<std::size_t>(dense.cols()), 1));
}

/// The factor L, with `size` rows, from its supernodes.
inline Eigen::MatrixXd dense_factor(const Supernodes& factor, Eigen::Index size) {
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(size, size);
  for (const Supernode& node : factor) {
    const Eigen::Map<const Eigen::MatrixXd> values(node.values, std::ssize(node.rows), node.width());
    L(node.rows, Eigen::seq(node.begin, node.end - 1)) = values.triangularView<Eigen::Lower>();
  }
  return L;
}

}  // namespace mapjoin::testing
