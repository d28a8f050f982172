// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One region's part of a least-squares problem, made from its factors, to be discarded once it is eliminated.

#include <mapjoin/distributed/regions/interface.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>

namespace mapjoin::distributed {

/// The joining system of a region, eliminated except for its border.
template <int Dim>
class RegionElimination {
 public:
  /// `order` is the elimination order, by places; it is found if empty.
  RegionElimination(const Region<Dim>& region, const Values<Dim>& estimate, const Border& border,
                    std::vector<PoseOrFeature>& order);
  RegionElimination(const RegionElimination&) = delete;
  RegionElimination& operator=(const RegionElimination&) = delete;

  /// Makes H and g at the estimate, and returns chi2 there; with curvature, H is that of full Newton.
  double linearise(bool with_curvature);
  const NormalEquations& equations() const { return system_.equations(); }
  /// Factorises all but the border; false if it is singular.
  bool factorise(double damping) { return !system_.factorise(damping); }
  /// A sentence on what is free to move while the border stays, once linearised; "" if nothing is. The names are by place.
  std::string free_to_move(const PoseIds& poses, const FeatureIds& features);
  /// Bytes of the factor, known before it is factorised.
  std::int64_t bytes() const { return solver_->bytes(); }
  /// The Schur complement over the border, by its lower triangle.
  ConstDenseBlock schur_complement() const { return solver_->schur_complement(); }

  /// L⁻¹ b, in elimination order: the border last.
  Eigen::VectorXd forward(const Eigen::VectorXd& b) const;
  /// The solution from y, which is forward() with the solution of the border in its last entries.
  Eigen::VectorXd backward(Eigen::VectorXd y) const;

 private:
  FactorGraph<Dim> graph_;
  SparseCholesky* solver_;  // owned by the system
  JoiningSystem<Dim> system_;
};

}  // namespace mapjoin::distributed
