// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small dense matrices in the storage of the sparse Cholesky factorisation.

#include <mapjoin/solve/sparse_cholesky.hpp>

namespace mapjoin::testing {

/// A dense matrix as the lower triangle of a sparse one, zeros left out, with one ignored entry above the diagonal per column.
inline SparseLower sparse(const Eigen::MatrixXd& dense) {
  SparseLower matrix;
  matrix.column_begin = {0};
  for (Eigen::Index j = 0; j < dense.cols(); ++j) {
    if (j > 0) {
      matrix.rows.push_back(j - 1);
      matrix.values.push_back(1e9);
    }
    for (Eigen::Index i = j; i < dense.rows(); ++i) {
      if (dense(i, j) == 0.0 && i != j) continue;
      matrix.rows.push_back(i);
      matrix.values.push_back(dense(i, j));
    }
    matrix.column_begin.push_back(static_cast<std::int64_t>(matrix.rows.size()));
  }
  return matrix;
}

}  // namespace mapjoin::testing
