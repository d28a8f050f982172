// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The dense steps of a Cholesky factorisation, by the BLAS and LAPACK on one thread.

#include <Eigen/Core>
#include <optional>
#include <string>

namespace mapjoin {

using DenseBlock = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstDenseBlock = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// A = L Lᵀ, by lower triangles, L in the place of A. Returns the first column whose pivot is not positive, or nothing.
std::optional<Eigen::Index> cholesky_in_place(DenseBlock A);
/// B ← B L⁻ᵀ.
void divide_by_transpose(ConstDenseBlock L, DenseBlock B);
/// The lower triangle of C ← C - B Bᵀ.
void subtract_square(ConstDenseBlock B, DenseBlock C);
/// C ← C - A Bᵀ.
void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C);

/// Threads are ours, over subtrees and tiles: those of the BLAS would be too many, and its sums would depend on their number.
/// The first of the above does this; to do it at once ends the threads that OpenBLAS starts, and lets spin, as soon as it is
/// loaded.
void keep_blas_on_one_thread();

/// The name of the BLAS in use, for the report.
std::string blas_name();

}  // namespace mapjoin
