// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One step of a multifrontal factorisation: the dense matrix in which a supernode is eliminated, by the BLAS and LAPACK.

#include <Eigen/Core>
#include <mapjoin/solve/engines/supernodal_tree.hpp>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

using DenseBlock = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstDenseBlock = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// A read-only view of a block.
inline ConstDenseBlock constant(const DenseBlock& block) {
  return {block.data(), block.rows(), block.cols(), Eigen::OuterStride<>(block.outerStride())};
}

/// Factorises A = L Lᵀ, by lower triangles, in place. Returns the first column whose pivot is not positive, or nullopt.
std::optional<Eigen::Index> cholesky_in_place(DenseBlock A);
/// B ← B L⁻ᵀ.
void divide_by_transpose(ConstDenseBlock L, DenseBlock B);
/// Treatment of the values in a block: a product is added to them, or replaces them unread.
enum class Into { kSum, kNew };
/// The lower triangle of C ← C - B Bᵀ, or of C ← -B Bᵀ.
void subtract_square(ConstDenseBlock B, DenseBlock C, Into into);
/// C ← C - A Bᵀ, or C ← -A Bᵀ.
void subtract_product(ConstDenseBlock A, ConstDenseBlock B, DenseBlock C, Into into);

/// The lower triangle of
///
///   ⎡ A_JJ  .    ⎤
///   ⎣ A_RJ  U_RR ⎦
///
/// over the rows J of a supernode and R below it; the columns of J are its panel, U is its update of the parent: -L_RJ L_RJᵀ
/// plus the updates of its children. U need not be set before the elimination.
struct FrontalMatrix {
  DenseBlock panel;
  DenseBlock update;
};

/// Adds the update of a child to one of these blocks, which begins at row and column `begin` of the front, in the columns that
/// the block has; `runs` give the child's rows.
void add_update(ConstDenseBlock update, std::span<const RowRun> runs, Eigen::Index begin, DenseBlock block);

/// Eliminates J: its panel becomes [L_JJ; L_RJ], the update, whatever it was, -L_RJ L_RJᵀ. Returns the singular columns of J,
/// judged by the matrix's `diagonal`: they are left out, with columns of the identity in L. All threads work on large fronts.
std::vector<Eigen::Index> eliminate(FrontalMatrix front, const Eigen::VectorXd& diagonal);

}  // namespace mapjoin
