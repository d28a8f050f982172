// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM over one region per rank, as one least-squares problem of which each rank holds a part.

#include <mapjoin/distributed/regions/region_metric.hpp>
#include <mapjoin/distributed/regions/region_solver.hpp>
#include <mapjoin/join/joining_system.hpp>

namespace mapjoin::distributed {

/// A LeastSquaresProblem that all ranks solve alike. A rank's vectors are over the variables that its region mentions: steps
/// have the same values of the interface on all ranks, the gradient is a sum over the ranks.
template <int Dim>
class RegionProblem {
 public:
  /// Each rank has one region, whose factors are given up.
  RegionProblem(const Communicator& comm, Regions<Dim>& regions, const MumpsOptions& options);
  RegionProblem(const RegionProblem&) = delete;
  RegionProblem& operator=(const RegionProblem&) = delete;

  double linearise() { return comm_.sum(system_.linearise()); }
  void add_curvature() { system_.add_curvature(); }
  const Eigen::VectorXd& gradient() const { return system_.gradient(); }
  double slope(const Eigen::VectorXd& v) const { return comm_.sum(gradient().dot(v)); }
  RegionMetric metric() const { return {comm_, shared_, system_.equations().diagonal()}; }
  double curvature(const Eigen::VectorXd& v) const { return comm_.sum(system_.curvature(v)); }
  std::optional<Variable> factorise(double damping);
  Eigen::VectorXd solve() const { return system_.solve(); }
  StepSize step_size(const Eigen::VectorXd& step) const;
  double try_step(const Eigen::VectorXd& step) { return comm_.sum(system_.try_step(step)); }
  void accept() { system_.accept(); }

  const Values<Dim>& estimate(std::size_t) const { return system_.estimate(); }
  const Interface& interface() const { return interface_; }
  RegionSolver& solver() { return *solver_; }
  /// Bytes of memory for the factor of this rank.
  std::int64_t factor_bytes() const { return solver_->bytes_in_memory(); }
  /// A sentence on what the last factorisation found free to move within this rank's region; "" if nothing.
  std::string free_here(const LogPart<Dim>& whole) const;

 private:
  const Communicator& comm_;
  const Region<Dim>& region_;
  FactorGraph<Dim> graph_;
  Interface interface_;
  RegionSolver* solver_;  // owned by the system
  JoiningSystem<Dim> system_;
  SharedEntries shared_;
  std::optional<Variable> singular_here_;
};

}  // namespace mapjoin::distributed
