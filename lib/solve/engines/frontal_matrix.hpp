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

/// A block that is only read.
inline ConstDenseBlock constant(const DenseBlock& block) {
  return {block.data(), block.rows(), block.cols(), Eigen::OuterStride<>(block.outerStride())};
}

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

/// The lower triangle of
///
///   ⎡ A_JJ  .    ⎤
///   ⎣ A_RJ  U_RR ⎦
///
/// over the rows J of a supernode and R below it; J's columns are its panel, U is what goes to its parent: -L_RJ L_RJᵀ and what
/// came from its children. U need not be set before the elimination.
struct FrontalMatrix {
  DenseBlock panel;
  DenseBlock update;
};

/// Adds to one of these blocks, which begins at row and column `begin` of the front, the columns that it has of what a child
/// sends; `runs` name the child's rows.
void add_update(ConstDenseBlock update, std::span<const RowRun> runs, Eigen::Index begin, DenseBlock block);

/// Eliminates J: its panel becomes [L_JJ; L_RJ], the update, whatever it was, -L_RJ L_RJᵀ. Returns the columns of J that are
/// singular, `diagonal` being the matrix's there: they are left out, their columns of L being those of the identity. Large
/// fronts are worked on by all threads.
std::vector<Eigen::Index> eliminate(FrontalMatrix front, const Eigen::VectorXd& diagonal);

}  // namespace mapjoin
