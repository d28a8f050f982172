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

/// A front that was eliminated before: what it sends over its rows enters the factorisation as the matrix does.
struct GivenFront {
  std::vector<Column> rows;  ///< Block rows, ascending; the matrix has a block for any two of them.
  ConstDenseBlock update;    ///< Over their scalars; the lower triangle.
  /// Instead of an update, what writes it when its turn comes, on any thread; it then lasts until its parent has taken it.
  std::function<void(DenseBlock)> make = nullptr;
};

/// L Lᵀ of a matrix that is already in its elimination order, as it stays: multifrontal (Duff & Reid, 1983), subtrees side by
/// side. The same to the last bit for any number of threads. With a border, the last so many block columns, it is partial:
///
///   ⎡ A_II  .    ⎤   ⎡ L_II  .  ⎤ ⎡ I  . ⎤ ⎡ L_IIᵀ  L_BIᵀ ⎤
///   ⎣ A_BI  A_BB ⎦ = ⎣ L_BI  I  ⎦ ⎣ .  S ⎦ ⎣ .      I     ⎦
///
/// with the Schur complement S = A_BB - A_BI A_II⁻¹ A_BIᵀ.
class SparseCholesky final : public SparseSolver {
 public:
  /// `folder` is for a file that holds L; empty: it stays in memory.
  explicit SparseCholesky(std::size_t border = 0, std::filesystem::path folder = {})
      : border_(border), folder_(std::move(folder)) {}

  void analyse(const BlockLower& matrix) override { analyse(matrix, {}); }
  void analyse(const BlockLower& matrix, std::span<const GivenFront> given);
  /// Makes room for L, once analysed, before factorise() does; throws as FactorValues.
  void make_room();
  /// Names all singular columns, and leaves them out: L has the columns of the identity there, so that what nothing determines
  /// stays where it is when a consistent system is solved.
  std::vector<std::int64_t> factorise(const BlockLower& matrix) override { return factorise(matrix, {}); }
  /// The same with given fronts, those of analyse(). A matrix without values is zero.
  std::vector<std::int64_t> factorise(const BlockLower& matrix, std::span<const GivenFront> given);
  /// Where there is no border.
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const override;
  /// The two halves of a solve: L⁻¹ B, whose rows of the border are the right-hand sides that belong to S; and L⁻ᵀ B, whose
  /// rows of the border are given.
  Eigen::MatrixXd solve_lower(Eigen::MatrixXd B) const;
  Eigen::MatrixXd solve_upper(Eigen::MatrixXd B) const;
  /// S by its lower triangle; empty without a border.
  ConstDenseBlock schur_complement() const;
  /// The null space of A, where it is positive semidefinite: a column for each of the given ones, which are singular.
  Eigen::MatrixXd null_space(const std::vector<std::int64_t>& singular) const;

  Supernode supernode_of(std::int64_t column) const override;
  std::size_t supernode_count() const override;
  std::int64_t bytes() const override { return static_cast<std::int64_t>(sizeof(double)) * tree_.value_count; }

 private:
  /// The columns of L of a front.
  ConstDenseBlock panel(const FactorNode& node) const;
  /// Neither given nor the border.
  bool is_eliminated(const FactorNode& node) const { return node.width > 0 && !tree_.is_border(node); }
  /// L⁻¹ B and L⁻ᵀ B in the place of B.
  void solve_upwards(Eigen::MatrixXd& B) const;
  void solve_downwards(Eigen::MatrixXd& B) const;

  std::size_t border_;  ///< Block columns.
  std::filesystem::path folder_;
  SupernodalTree tree_;
  Table<Column, Eigen::Index> offsets_;  ///< The first scalar row of each block, and the total.
  FactorValues values_;                  ///< The panels of L.
};

/// The fronts of a factorisation, each with values of its own, for whoever keeps some of them longer than others.
struct EliminatedFronts {
  SupernodalTree tree;                   ///< Given fronts are nodes without columns.
  std::vector<Eigen::MatrixXd> panels;   ///< Of L, per node, by the lower trapezoid: height × width; empty of a given front.
  std::vector<Eigen::MatrixXd> updates;  ///< What each node sends, by the lower triangle; empty of a given front.
  std::vector<std::int64_t> singular;    ///< As of SparseCholesky::factorise().
};
/// The same factorisation as SparseCholesky's without a border.
EliminatedFronts eliminate_fronts(const BlockLower& matrix, std::span<const GivenFront> given);

}  // namespace mapjoin
