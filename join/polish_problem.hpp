// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Polishing is the join again: each map's interior is eliminated at the current estimate instead of the local one, and the
// joining system, with its pattern, ordering and symbolic factor, becomes the exact Gauss-Newton system of the whole log
// (paper's (8), (9)).

#include <Eigen/Core>
#include <mapjoin/join/joint_system.hpp>
#include <mapjoin/join/live_segment.hpp>
#include <mapjoin/localmap/segment.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace mapjoin {

/// A LeastSquaresProblem over every pose and feature of a log. A step is the joined state's, then each segment's own variables.
template <int Dim>
class PolishProblem {
 public:
  /// `system` is the joining system of the whole network, whose maps are those of `segments`, in the same order, without their
  /// private features. `state` is over the whole log; all arguments but it must outlive the problem.
  PolishProblem(JointSystem<Dim>& system, const std::vector<Segment<Dim>>& segments, const std::vector<bool>& is_private,
                const State<Dim>& state);

  double linearise();
  const Eigen::VectorXd& gradient() const { return gradient_; }
  DiagonalMetric metric() const;
  double curvature(const Eigen::VectorXd& v);
  std::optional<Index> factorise(double damping);
  Eigen::VectorXd solve();
  StepSize step_size(const Eigen::VectorXd& step) const;
  double try_step(const Eigen::VectorXd& step);
  void accept();

  /// Puts what belongs to the segments alone, interior poses and private features, into the state of the whole log.
  void write_interiors(State<Dim>& state) const;

 private:
  bool eliminate_segments(double damping);
  /// The normal equations of the single observations alone, if they hold the segments, too.
  void restore_observations();

  JointSystem<Dim>& system_;
  std::vector<std::unique_ptr<LiveSegment<Dim>>> segments_;
  Eigen::Index size_ = 0;
  Eigen::VectorXd gradient_;
  State<Dim> candidate_;
  bool is_reduced_ = false;  // whether the normal equations hold the segments, too
};

}  // namespace mapjoin
