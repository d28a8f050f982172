// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The engine `fronts`: a multifrontal factorisation along the elimination tree of blocks.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <mapjoin/solve/engines/factor_values.hpp>
#include <mapjoin/solve/engines/frontal_matrix.hpp>
#include <mapjoin/solve/engines/supernodal_tree.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// A front that was eliminated before: its update enters the factorisation as the matrix does.
struct GivenFront {
  std::vector<Column> rows;  ///< Block rows, ascending; the matrix has a block for any two of them.
  ConstDenseBlock update;    ///< Update over their scalar rows; the lower triangle.
  /// Writer of the update instead of `update`, called when it is needed, on any thread; the update then lasts until its parent
  /// has taken it.
  std::function<void(DenseBlock)> make = nullptr;
};

/// The multifrontal factorisation L Lᵀ (Duff & Reid, 1983) of a matrix given in its elimination order, which is kept; subtrees
/// in parallel. The same to the last bit for any number of threads. With a border of block columns at the end it is partial:
///
///   ⎡ A_II  .    ⎤   ⎡ L_II  .  ⎤ ⎡ I  . ⎤ ⎡ L_IIᵀ  L_BIᵀ ⎤
///   ⎣ A_BI  A_BB ⎦ = ⎣ L_BI  I  ⎦ ⎣ .  S ⎦ ⎣ .      I     ⎦
///
/// with the Schur complement S = A_BB - A_BI A_II⁻¹ A_BIᵀ.
class SparseCholesky final : public SparseSolver {
 public:
  /// Takes the number of block columns in the border, and the folder of a file that holds L; empty: L stays in memory.
  explicit SparseCholesky(std::size_t border = 0, std::filesystem::path folder = {})
      : border_(border), folder_(std::move(folder)) {}

  void analyse(const BlockLower& matrix) override { analyse(matrix, {}); }
  void analyse(const BlockLower& matrix, std::span<const GivenFront> given);
  /// Allocates L, once analysed, ahead of factorise(); throws as FactorValues does.
  void make_room();
  /// Returns all singular columns, and leaves them out: L has columns of the identity there, so that undetermined variables
  /// stay where they are when a consistent system is solved.
  std::vector<std::int64_t> factorise(const BlockLower& matrix) override { return factorise(matrix, {}); }
  /// Factorises with given fronts, those of analyse(). A matrix without values is zero.
  std::vector<std::int64_t> factorise(const BlockLower& matrix, std::span<const GivenFront> given);
  /// Solves with A, if there is no border.
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const override;
  /// The two halves of a solve: L⁻¹ B, with the right-hand sides of S in the rows of the border, and L⁻ᵀ B, with the solution
  /// for S in the rows of the border of B.
  Eigen::MatrixXd solve_lower(Eigen::MatrixXd B) const;
  Eigen::MatrixXd solve_upper(Eigen::MatrixXd B) const;
  /// The Schur complement S by its lower triangle; empty without a border.
  ConstDenseBlock schur_complement() const;
  /// Directions of the null space of the factorised A, which must be positive semidefinite: a column for each of its singular
  /// columns, of the first `most` of these. With a border they are of A_II, and the border stays.
  Eigen::MatrixXd null_space(std::size_t most) const;

  Supernode supernode_of(std::int64_t column) const override;
  std::size_t supernode_count() const override;
  std::int64_t bytes() const override { return static_cast<std::int64_t>(sizeof(double)) * tree_.value_count; }

 private:
  /// The columns of L of a front.
  ConstDenseBlock panel(const FactorNode& node) const;
  /// True if the node is neither given nor the border.
  bool is_eliminated(const FactorNode& node) const { return node.width > 0 && !tree_.is_border(node); }
  /// Replace B by L⁻¹ B and by L⁻ᵀ B.
  void solve_upwards(Eigen::MatrixXd& B) const;
  void solve_downwards(Eigen::MatrixXd& B) const;

  std::size_t border_;  ///< Number of block columns.
  std::filesystem::path folder_;
  SupernodalTree tree_;
  Table<Column, Eigen::Index> offsets_;  ///< The first scalar row of each block, and the total.
  FactorValues values_;                  ///< The panels of L.
  std::vector<std::int64_t> singular_;   ///< Singular columns of the last factorisation.
};

/// The fronts of a factorisation, each with values of its own, for callers that keep some of them longer than others.
struct EliminatedFronts {
  SupernodalTree tree;                   ///< Given fronts are nodes without columns.
  std::vector<Eigen::MatrixXd> panels;   ///< L per node, by the lower trapezoid: height × width; empty for a given front.
  std::vector<Eigen::MatrixXd> updates;  ///< Update of each node, by the lower triangle; empty for a given front.
  std::vector<std::int64_t> singular;    ///< Singular columns, as of SparseCholesky::factorise().
};
/// Factorises as SparseCholesky does without a border.
EliminatedFronts eliminate_fronts(const BlockLower& matrix, std::span<const GivenFront> given);

}  // namespace mapjoin
