// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Normal equations of a chain of poses with a dense border: the interior of a local map, eliminated pose by pose.
//
//   | D_1 L_1         E_1 | | δ_1 |   | g_1 |
//   | L_1ᵀ D_2 L_2    E_2 | | δ_2 | = | g_2 |     chain: one block per interior pose, coupled to its neighbour
//   |      L_2ᵀ …     …   | | …   |   | …   |
//   | E_1ᵀ E_2ᵀ …     C   | | δ_b |   | g_b |     border: everything else, dense

#include <Eigen/Core>
#include <mapjoin/geometry/pose.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
class ChainSystem {
 public:
  static constexpr int kDof = kPoseDof<Dim>;

  ChainSystem(Eigen::Index chain_length, Eigen::Index border_size);

  void set_zero();

  Eigen::Index chain_length() const { return static_cast<Eigen::Index>(D_.size()); }
  Eigen::Index border_size() const { return C_.rows(); }
  /// Chain entries, then border entries.
  Eigen::Index size() const { return chain_length() * kDof + border_size(); }

  Matrix<kDof>& diagonal_block(Eigen::Index k) { return D_[static_cast<std::size_t>(k)]; }
  /// The coupling of chain pose k with k + 1.
  Matrix<kDof>& coupling(Eigen::Index k) { return L_[static_cast<std::size_t>(k)]; }
  /// The couplings of chain pose k with the border, kDof × border_size(); only if there is a border.
  auto border_rows(Eigen::Index k) { return E_.middleRows<kDof>(k * kDof); }
  /// C, the block of the border; only its upper triangle counts.
  Eigen::MatrixXd& border() { return C_; }
  const Eigen::MatrixXd& border() const { return C_; }
  /// g of the chain, then of the border.
  Eigen::VectorXd& gradient() { return g_; }
  const Eigen::VectorXd& gradient() const { return g_; }

  Eigen::VectorXd diagonal() const;
  /// vᵀ H v, before elimination.
  double curvature(const Eigen::VectorXd& v) const;
  /// Replaces H by H + damping·diag(H), before elimination.
  void damp(double damping);

  /// Eliminates the chain: the border and its gradient become their Schur complements, and the blocks of chain pose k become
  /// G_k, G_k⁻¹ L_k and G_k⁻¹ E_k, where G_k G_kᵀ is the reduced D_k. False if a chain block is singular to working precision.
  /// O(chain · border²).
  bool eliminate_chain();
  /// Eliminates another gradient in place of the one that was eliminated with the chain.
  void eliminate_gradient(const Eigen::VectorXd& gradient);
  /// The chain's part of the solution, given the border's, after eliminate_chain().
  Eigen::VectorXd chain_step(const Eigen::VectorXd& border_step) const;

 private:
  std::vector<Matrix<kDof>> D_;  // after elimination: the Cholesky factor G_k of the reduced D_k
  std::vector<Matrix<kDof>> L_;  // after elimination: G_k⁻¹ L_k
  Eigen::MatrixXd E_;            // after elimination: G_k⁻¹ E_k
  Eigen::MatrixXd C_;            // after elimination: its Schur complement
  Eigen::VectorXd g_;            // after elimination: G_k⁻¹ g_k, and the border's Schur complement
};

}  // namespace mapjoin
