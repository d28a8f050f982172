// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A front: variables eliminated together from a dense part of the normal equations, and what that leaves to their parent.
//
//   | H_ff  ·    | | δ_f |   | b_f |      L_ff L_ffᵀ = H_ff,  L_sf = H_sf L_ff⁻ᵀ,  y = L_ff⁻¹ b_f
//   | H_sf  H_ss | | δ_s | = | b_s |      to the parent:  H_ss - L_sf L_sfᵀ,  b_s - L_sf y

#include <Eigen/Core>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// A quadratic δᵀHδ - 2 bᵀδ over some variables' entries, one after the other. Only the lower triangle of H counts.
struct Quadratic {
  std::vector<Index> variables;
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};

class Front {
 public:
  Front() = default;
  /// Eliminates the first `frontal_size` entries of `whole`, which are the first `frontal_count` variables. Where they are not
  /// determined, they are damped as little as makes them so.
  Front(Quadratic whole, std::size_t frontal_count, Eigen::Index frontal_size);

  const std::vector<Index>& frontals() const { return frontals_; }
  /// What is left, over the separator.
  const Quadratic& message() const { return message_; }
  /// δ_f, given δ_s.
  Eigen::VectorXd solve(const Eigen::VectorXd& separator_step) const;
  /// vᵀ L_ff L_ffᵀ v: a change of δ_f in squared standard deviations, the separator being held.
  double squared_deviations(const Eigen::VectorXd& v) const;

 private:
  std::vector<Index> frontals_;
  Eigen::MatrixXd L_;  // L_ff over L_sf
  Eigen::VectorXd y_;
  Quadratic message_;
};

}  // namespace mapjoin
