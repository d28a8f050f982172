// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Symmetric matrices as files store them: the upper triangle, row by row.

#include <mapjoin/geometry/rotation.hpp>

namespace mapjoin {

/// Visits the entries M(i, j), i ≤ j, of a square matrix.
template <typename Derived, typename Visit>
void each_of_upper_triangle(const Eigen::MatrixBase<Derived>& M, Visit&& visit) {
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    for (Eigen::Index j = i; j < M.cols(); ++j) visit(M(i, j));
  }
}

/// The symmetric matrix whose upper triangle comes from calls of `next`, row by row.
template <int Size, typename Next>
Matrix<Size> from_upper_triangle(Next&& next) {
  Matrix<Size> M;
  for (int i = 0; i < Size; ++i) {
    for (int j = i; j < Size; ++j) M(i, j) = M(j, i) = next();
  }
  return M;
}

}  // namespace mapjoin
