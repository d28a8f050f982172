// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small dense matrices in the storage of the sparse Cholesky factorisation.

#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin::testing {

/// A dense matrix as the upper triangle of a sparse one, zeros left out, with one ignored entry below the diagonal per column.
inline SparseUpper sparse(const Eigen::MatrixXd& dense) {
  SparseUpper matrix;
  matrix.column_begin = {0};
  for (Eigen::Index j = 0; j < dense.cols(); ++j) {
    for (Eigen::Index i = 0; i <= j; ++i) {
      if (dense(i, j) == 0.0 && i != j) continue;
      matrix.rows.push_back(i);
      matrix.values.push_back(dense(i, j));
    }
    if (j + 1 < dense.cols()) {
      matrix.rows.push_back(j + 1);
      matrix.values.push_back(1e9);
    }
    matrix.column_begin.push_back(static_cast<std::int64_t>(matrix.rows.size()));
  }
  return matrix;
}

}  // namespace mapjoin::testing
