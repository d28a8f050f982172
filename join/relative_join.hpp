// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join with its steps in the coordinates of either joined state.

#include <Eigen/Core>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/relative_state.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <stop_token>

namespace mapjoin {

/// A LeastSquaresProblem: a join with its steps in relative coordinates. The linear system is the absolute one; only its
/// solution is applied in another way.
template <int Dim>
class RelativeJoin {
 public:
  explicit RelativeJoin(JoiningSystem<Dim>& join) : join_(join), relative_(join) {}

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return join_.gradient(); }
  const RelativeState<Dim>& metric();
  double curvature(const Eigen::VectorXd& v);
  std::optional<Variable> factorise(double damping);
  Eigen::VectorXd solve() const { return join_.solve(); }
  StepSize step_size(const Eigen::VectorXd& step) const { return join_.step_size(step); }
  /// The chi2 after a step in relative coordinates. A step of full Newton is taken in absolute ones, to which its H belongs.
  double try_step(const Eigen::VectorXd& step) {
    return is_factor_curved_ ? join_.try_step(step) : join_.try_state(relative_.retracted(join_, step));
  }
  void accept() { join_.accept(); }

 private:
  void undamp();

  JoiningSystem<Dim>& join_;
  RelativeState<Dim> relative_;
  bool is_weighed_ = false;  // true if the metric is that of the estimate
  bool is_curved_ = false;   // true if the normal equations include the curvature
  bool is_damped_ = false;   // true if the normal equations include the damping
  bool is_factor_curved_ = false;
};

/// Minimises a join with steps in the coordinates of `state`.
template <int Dim>
MinimiseResult minimise_join(JoiningSystem<Dim>& join, JoinedState state, const MinimiseOptions& options,
                             const std::stop_token& stop = {});

}  // namespace mapjoin
