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
/// Whether a product is added to what is in a block already, or that is not even read.
enum class Into { kSum, kNew };
/// The lower triangle of C ← C - B Bᵀ, or of C ← -B Bᵀ.
void subtract_square(ConstDenseBlock B, DenseBlock C, Into into);
/// C ← C - A Bᵀ, or C ← -A Bᵀ.
void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into);

/// Ends the threads that OpenBLAS starts, and lets spin, as soon as it is loaded; the above need none. For a program that uses
/// the BLAS through this alone, before it does.
void end_blas_threads();

/// The name of the BLAS in use, for the report.
std::string blas_name();

}  // namespace mapjoin
