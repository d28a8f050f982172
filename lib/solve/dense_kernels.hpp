// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The dense steps of a Cholesky factorisation, by the BLAS and LAPACK. Several threads may call them at once.

#include <Eigen/Core>
#include <optional>

namespace mapjoin {

using DenseBlock = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstDenseBlock = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// A = L Lᵀ, by lower triangles, L in the place of A. Returns the first column whose pivot is not positive, or nothing.
std::optional<Eigen::Index> cholesky_in_place(DenseBlock A);
/// B ← B L⁻ᵀ.
void divide_by_transpose(ConstDenseBlock L, DenseBlock B);
/// Whether a product is added to what is in a block already, or that is not even read.
enum class Into { kSum, kNew };
/// The lower triangle of C ← C - B Bᵀ, or of C ← -B Bᵀ.
void subtract_square(ConstDenseBlock B, DenseBlock C, Into into);
/// C ← C - A Bᵀ, or C ← -A Bᵀ.
void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into);

}  // namespace mapjoin
