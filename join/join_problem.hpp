// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining as a least-squares problem: each local map is one integrated observation (paper's (31), (32)).

#include <Eigen/Core>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/relative_state.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <stop_token>
#include <utility>

namespace mapjoin {

/// A LeastSquaresProblem over the joined state of a partial map.
template <int Dim>
class JoinProblem {
 public:
  JoinProblem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, Engine engine = Engine::kFronts)
      : system_(partial, gauge, engine) {}
  explicit JoinProblem(JoiningSystem<Dim> system) : system_(std::move(system)) {}

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return system_.equations().gradient(); }
  DiagonalMetric metric() const { return DiagonalMetric(system_.equations().diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return system_.equations().curvature(v); }
  std::optional<Variable> factorise(double damping) { return system_.equations().factorise(damping); }
  Eigen::VectorXd solve() const { return system_.equations().solve(gradient()); }
  StepSize step_size(const Eigen::VectorXd& step) const { return system_.step_size(step); }
  double try_step(const Eigen::VectorXd& step) { return try_state(system_.retracted(step)); }
  /// chi2 of a state, kept as the candidate.
  double try_state(Values<Dim> candidate);
  void accept() { std::swap(system_.estimate(), candidate_); }

  const Values<Dim>& estimate() const { return system_.estimate(); }
  /// The system with its pattern, ordering and symbolic factor.
  JoiningSystem<Dim>& system() { return system_; }
  const JoiningSystem<Dim>& system() const { return system_; }
  /// f(the factor linearised at the estimate): a LinearObservation or a LinearMap.
  template <typename F>
  auto with_linear_factor(std::size_t factor, F&& f) const {
    const auto [kind, place] = system_.source_of(factor);
    if (kind == JoiningSystem<Dim>::Source::kMap) return f(linear_map(place));
    return system_.with_linear_observation(factor, std::forward<F>(f));
  }

 private:
  LinearMap<Dim> linear_map(std::size_t m) const;

  JoiningSystem<Dim> system_;
  Values<Dim> candidate_;
};

/// A join problem with its steps in relative coordinates: the same linear system, another way of applying what solves it.
template <int Dim>
class RelativeJoinProblem {
 public:
  explicit RelativeJoinProblem(JoinProblem<Dim>& join) : join_(join), relative_(join.system()) {}

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return join_.gradient(); }
  const RelativeState<Dim>& metric();
  double curvature(const Eigen::VectorXd& v);
  std::optional<Variable> factorise(double damping);
  Eigen::VectorXd solve() const { return join_.solve(); }
  StepSize step_size(const Eigen::VectorXd& step) const { return join_.step_size(step); }
  /// The step of full Newton is one in the absolute coordinates that its H is of.
  double try_step(const Eigen::VectorXd& step) {
    return is_curved_ ? join_.try_step(step) : join_.try_state(relative_.retracted(join_.system(), step));
  }
  void accept() { join_.accept(); }

 private:
  void undamp();

  JoinProblem<Dim>& join_;
  RelativeState<Dim> relative_;
  bool is_weighed_ = false;  // whether the metric is that of the estimate
  bool is_curved_ = false;   // whether the normal equations hold the curvature, too,
  bool is_damped_ = false;   // and the damping
};

/// Minimises with steps in the coordinates of `state`.
template <int Dim>
MinimiseResult minimise_join(JoinProblem<Dim>& problem, JoinedState state, const MinimiseOptions& options,
                             const std::stop_token& stop = {});

/// chi2 of a local map as an observation of `state`, whose poses and features stand at the given places.
template <int Dim>
double map_chi2(const typename JoiningSystem<Dim>::PlacedMap& placed, const Values<Dim>& state);

/// chi2 of all observations and maps of a partial map at its state.
template <int Dim>
double partial_map_chi2(const PartialMap<Dim>& partial);

}  // namespace mapjoin
