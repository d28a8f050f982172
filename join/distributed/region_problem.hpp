// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM over all regions as one least-squares problem, of which each rank holds a part.

#include <mapjoin/distributed/region_solver.hpp>
#include <mapjoin/join/joining_system.hpp>

namespace mapjoin::distributed {

/// D = diag(H), a sum over the ranks like H.
class RegionMetric {
 public:
  RegionMetric(const Communicator& comm, const Interface& interface, const std::vector<Eigen::Index>& entries,
               Eigen::VectorXd diagonal)
      : comm_(comm), interface_(interface), entries_(entries), own_(std::move(diagonal)) {}

  double inner(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const { return comm_.sum(own_.inner(u, v)); }
  Eigen::VectorXd descent(const Eigen::VectorXd& gradient) const {
    return DiagonalMetric(assembled(own_.diagonal())).descent(assembled(gradient));
  }

 private:
  /// The sums over all ranks of what each has at the interface.
  Eigen::VectorXd assembled(Eigen::VectorXd v) const;

  const Communicator& comm_;
  const Interface& interface_;
  const std::vector<Eigen::Index>& entries_;  // of the interface's unknowns in vectors
  DiagonalMetric own_;
};

/// A LeastSquaresProblem that all ranks solve alike. A rank's vectors are over the variables that its region mentions: steps
/// have the same values of the interface on all ranks, the gradient is a sum over them.
template <int Dim>
class RegionProblem {
 public:
  RegionProblem(const Communicator& comm, const Region<Dim>& region, const MumpsOptions& options);
  RegionProblem(const RegionProblem&) = delete;
  RegionProblem& operator=(const RegionProblem&) = delete;

  double linearise() { return comm_.sum(system_.linearise()); }
  void add_curvature() { system_.add_curvature(); }
  const Eigen::VectorXd& gradient() const { return system_.gradient(); }
  double slope(const Eigen::VectorXd& v) const { return comm_.sum(gradient().dot(v)); }
  RegionMetric metric() const { return {comm_, interface_, entries_, system_.equations().diagonal()}; }
  double curvature(const Eigen::VectorXd& v) const { return comm_.sum(system_.curvature(v)); }
  std::optional<Variable> factorise(double damping) { return system_.factorise(damping); }
  Eigen::VectorXd solve() const { return system_.solve(); }
  StepSize step_size(const Eigen::VectorXd& step) const;
  double try_step(const Eigen::VectorXd& step) { return comm_.sum(system_.try_step(step)); }
  void accept() { system_.accept(); }

  const JoiningSystem<Dim>& system() const { return system_; }
  const RegionSolver& solver() const { return *solver_; }
  const Interface& interface() const { return interface_; }

 private:
  const Communicator& comm_;
  Interface interface_;
  RegionSolver* solver_;  // of the system
  JoiningSystem<Dim> system_;
  std::vector<Eigen::Index> entries_;
};

}  // namespace mapjoin::distributed
