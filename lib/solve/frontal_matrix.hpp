// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One step of a multifrontal factorisation: the dense matrix in which a supernode is eliminated.

#include <mapjoin/solve/dense_kernels.hpp>
#include <mapjoin/solve/supernodal_tree.hpp>
#include <span>
#include <vector>

namespace mapjoin {

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
