// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One region's part of a least-squares problem, made from its factors, to be thrown away once it is eliminated.

#include <mapjoin/distributed/regions/interface.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>

namespace mapjoin::distributed {

/// The joining system of a region, of which all but its border is eliminated.
template <int Dim>
class RegionElimination {
 public:
  /// `order` is that of the elimination, by places, and is found where it is empty.
  RegionElimination(const Region<Dim>& region, const Values<Dim>& estimate, const Border& border,
                    std::vector<PoseOrFeature>& order);
  RegionElimination(const RegionElimination&) = delete;
  RegionElimination& operator=(const RegionElimination&) = delete;

  /// Makes H and g at the estimate, and returns chi2 there; with curvature, H is that of full Newton.
  double linearise(bool with_curvature);
  const NormalEquations& equations() const { return system_.equations(); }
  /// A place that is singular, or nothing.
  std::optional<PoseOrFeature> factorise(double damping);
  /// Of its factor, known before it is factorised.
  std::int64_t bytes() const { return solver_->bytes(); }
  /// By its lower triangle.
  ConstDenseBlock schur_complement() const { return solver_->schur_complement(); }

  /// L⁻¹ b, in the order of the elimination: the border last.
  Eigen::VectorXd forward(const Eigen::VectorXd& b) const;
  /// The solution, whose border is given in the last entries of forward().
  Eigen::VectorXd backward(Eigen::VectorXd y) const;

 private:
  FactorGraph<Dim> graph_;
  SparseCholesky* solver_;  // of the system
  JoiningSystem<Dim> system_;
};

}  // namespace mapjoin::distributed
