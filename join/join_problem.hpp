// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining as a least-squares problem: each local map is one integrated observation (paper's (31), (32)).

#include <Eigen/Core>
#include <mapjoin/join/joint_system.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <utility>

namespace mapjoin {

/// A LeastSquaresProblem over the joined state of a piece.
template <int Dim>
class JoinProblem {
 public:
  JoinProblem(const Piece<Dim>& piece, const Gauge<Dim>& gauge) : system_(piece, gauge) {}
  explicit JoinProblem(JointSystem<Dim> system) : system_(std::move(system)) {}

  double linearise();
  const Eigen::VectorXd& gradient() const { return system_.equations().gradient(); }
  DiagonalMetric metric() const { return DiagonalMetric(system_.equations().diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return system_.equations().curvature(v); }
  std::optional<Index> factorise(double damping) { return system_.equations().factorise(damping); }
  Eigen::VectorXd solve() const { return system_.equations().solve(gradient()); }
  StepSize step_size(const Eigen::VectorXd& step) const { return system_.step_size(step); }
  double try_step(const Eigen::VectorXd& step);
  void accept() { std::swap(system_.estimate(), candidate_); }

  const State<Dim>& estimate() const { return system_.estimate(); }
  /// The system with its pattern, ordering and symbolic factor, for polishing.
  JointSystem<Dim>& system() { return system_; }

 private:
  JointSystem<Dim> system_;
  State<Dim> candidate_;
};

/// chi2 of a local map as an observation of `state`, whose poses and features stand at the given places.
template <int Dim>
double map_chi2(const typename JointSystem<Dim>::PlacedMap& placed, const State<Dim>& state);

/// chi2 of all observations and maps of a piece at its state.
template <int Dim>
double piece_chi2(const Piece<Dim>& piece);

}  // namespace mapjoin
