// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One step of a multifrontal factorisation: the dense matrix in which a supernode is eliminated.

#include <mapjoin/solve/dense_kernels.hpp>
#include <mapjoin/solve/supernodal_tree.hpp>
#include <optional>
#include <span>

namespace mapjoin {

/// The lower triangle of
///
///   ⎡ A_JJ  .    ⎤
///   ⎣ A_RJ  U_RR ⎦
///
/// over the rows J of a supernode and R below it; J's columns are its panel, U is what goes to its parent.
struct FrontalMatrix {
  DenseBlock panel;
  DenseBlock update;
};

/// Adds what a child sends its parent, whose rows `runs` name.
void add_update(ConstDenseBlock update, std::span<const RowRun> runs, FrontalMatrix parent);

/// Eliminates J: its panel becomes [L_JJ; L_RJ], the update U_RR - L_RJ L_RJᵀ. Returns the first column of J whose pivot is not
/// positive, or nothing. Large fronts are worked on by all threads.
std::optional<Eigen::Index> eliminate(FrontalMatrix front);

}  // namespace mapjoin
