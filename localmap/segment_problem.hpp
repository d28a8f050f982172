// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One segment as a least-squares problem of its own: building a local map, and recovering its interior.

#include <Eigen/Core>
#include <mapjoin/localmap/segment_system.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>

namespace mapjoin {

/// A LeastSquaresProblem over the free variables of a segment, solved by eliminating the chain, then the border densely.
template <int Dim>
class SegmentProblem {
 public:
  SegmentProblem(const SegmentView<Dim>& view, const SegmentFreedom& freedom, Values<Dim> start);

  double linearise();
  void add_curvature() { system_.add_curvature(estimate_); }
  const Eigen::VectorXd& gradient() const { return system_.equations().gradient(); }
  DiagonalMetric metric() const { return DiagonalMetric(system_.equations().diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return system_.equations().curvature(v); }
  std::optional<Variable> factorise(double damping);
  Eigen::VectorXd solve();
  StepSize step_size(const Eigen::VectorXd& step) const { return system_.step_size(step); }
  double try_step(const Eigen::VectorXd& step);
  void accept() { estimate_ = candidate_; }

  const Values<Dim>& estimate() const { return estimate_; }
  /// The information of the border with the chain eliminated, at the estimate: W of the local map. Nothing where it is
  /// singular.
  std::optional<Eigen::MatrixXd> marginal_information();

 private:
  SegmentSystem<Dim> system_;
  ChainSystem<Dim> factored_;
  Eigen::MatrixXd border_factor_;  // lower triangle
  bool is_eliminated_ = false;     // whether the gradient of `factored_` is that of the estimate
  Values<Dim> estimate_;
  Values<Dim> candidate_;
};

/// Poses and features of a segment in the frame of its first pose, from odometry and first observations.
template <int Dim>
Values<Dim> composed_start(const SegmentView<Dim>& view);

}  // namespace mapjoin
