// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small dense matrices in the storage of the sparse Cholesky factorisation.

#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin::testing {

/// A dense matrix by blocks of these sizes, zero blocks left out, with 1e9 where entries above the diagonal are ignored.
inline BlockLower sparse(const Eigen::MatrixXd& dense, const std::vector<Eigen::Index>& dofs) {
  BlockLower matrix;
  for (const Eigen::Index dof : dofs) matrix.offsets.push_back(matrix.offsets.back() + dof);
  const auto block = [&](std::size_t i, std::size_t j) {
    return dense.block(matrix.offsets[i], matrix.offsets[j], dofs[i], dofs[j]);
  };
  for (std::size_t j = 0; j < dofs.size(); ++j) {
    std::vector<Index> rows{static_cast<Index>(j)};
    for (std::size_t i = j + 1; i < dofs.size(); ++i) {
      if (!block(i, j).isZero(0.0)) rows.push_back(static_cast<Index>(i));
    }
    matrix.append_column(rows);
  }
  matrix.lay_out();
  for (std::size_t j = 0; j < dofs.size(); ++j) {
    Eigen::Map<Eigen::MatrixXd> panel(matrix.values.data() + matrix.first_value[j], matrix.heights[j], dofs[j]);
    Eigen::Index row = 0;
    for (const Index i : matrix.rows_of(j)) {
      panel.middleRows(row, dofs[static_cast<std::size_t>(i)]) = block(static_cast<std::size_t>(i), j);
      row += dofs[static_cast<std::size_t>(i)];
    }
    panel.topRows(dofs[j]).triangularView<Eigen::StrictlyUpper>().fill(1e9);
  }
  return matrix;
}

/// The same, entry by entry.
inline BlockLower sparse(const Eigen::MatrixXd& dense) {
  return sparse(dense, std::vector<Eigen::Index>(static_cast<std::size_t>(dense.cols()), 1));
}

}  // namespace mapjoin::testing
