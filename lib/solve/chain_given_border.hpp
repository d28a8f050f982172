// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The Gaussian of a chain of poses given its border: what is recovered after the border is known, with its covariance.
//
// With the factors of ChainSystem and T_k = -G_k⁻ᵀ (G_k⁻¹ L_k), going back from the last pose,
//
//   δ_k = M_k δ_b + e_k,   M_k = -G_k⁻ᵀ (G_k⁻¹ E_k) + T_k M_k+1,
//   cov e_k = G_k⁻ᵀ G_k⁻¹ + T_k (cov e_k+1) T_kᵀ,   cov(e_k, e_m) = T_k cov(e_k+1, e_m),  k < m.

#include <Eigen/Core>
#include <mapjoin/solve/chain_system.hpp>
#include <span>
#include <vector>

namespace mapjoin {

template <int Dim>
class ChainGivenBorder {
 public:
  static constexpr int kDof = kPoseDof<Dim>;

  /// Of no chain.
  ChainGivenBorder() = default;
  /// `eliminated` after eliminate_chain(). O(chain · border).
  explicit ChainGivenBorder(const ChainSystem<Dim>& eliminated);

  /// M: how the chain follows the border, (chain · kDof) × border.
  const Eigen::MatrixXd& gain() const { return gain_; }
  /// The joint covariance of chain poses, ascending, where the border stands still. O(their number · the chain from the first
  /// of them to the last).
  Eigen::MatrixXd covariance(std::span<const Eigen::Index> poses) const;

 private:
  Eigen::MatrixXd gain_;
  std::vector<Matrix<kDof>> covariances_;  // of e_k
  std::vector<Matrix<kDof>> transfers_;    // T_k
};

}  // namespace mapjoin
