// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One segment as a least-squares problem of its own: building a local map, and recovering its interior.

#include <Eigen/Core>
#include <mapjoin/localmap/chain_system.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// The free variables besides the interior poses.
struct SegmentFreedom {
  bool kept = true;
  Table<FeatureIndex, bool> features;  ///< By place in the segment.
};

/// A LeastSquaresProblem over the free variables of a segment, solved by eliminating the chain of its interior poses, then the
/// border densely: the kept poses and the features that are free. Values are poses begin..end and features by their places in
/// the segment.
template <int Dim>
class SegmentProblem {
 public:
  /// `view` must outlive the problem.
  SegmentProblem(const SegmentView<Dim>& view, const SegmentFreedom& freedom, Values<Dim> start);

  double linearise();
  void add_curvature();
  const Eigen::VectorXd& gradient() const { return equations_.gradient(); }
  DiagonalMetric metric() const { return DiagonalMetric(equations_.diagonal()); }
  double curvature(const Eigen::VectorXd& v) const { return equations_.curvature(v); }
  std::optional<Variable> factorise(double damping);
  Eigen::VectorXd solve();
  StepSize step_size(const Eigen::VectorXd& step) const;
  double try_step(const Eigen::VectorXd& step);
  void accept() { estimate_ = candidate_; }

  const Values<Dim>& estimate() const { return estimate_; }
  /// The information of the border with the chain eliminated, at the estimate: W of the local map. nullopt if the system is
  /// singular.
  std::optional<Eigen::MatrixXd> marginal_information();

 private:
  static constexpr int kDof = kPoseDof<Dim>;
  /// The entry of a variable in the step, the chain's first; kStill if it is held.
  using Entry = Eigen::Index;
  static constexpr Entry kStill = -1;
  class Sink;

  /// The sum of f(observation linearised at the estimate, sink) over the observations of the segment.
  template <typename F>
  double sum_linear(F&& f);
  double chi2(const Values<Dim>& values) const;
  Values<Dim> retracted(const Eigen::VectorXd& step) const;

  const SegmentView<Dim>* view_;
  Table<PoseIndex, Entry> pose_entries_;
  Table<FeatureIndex, Entry> feature_entries_;
  std::vector<FeatureIndex> observed_;  // place of the feature of each observation
  ChainSystem<Dim> equations_;
  ChainSystem<Dim> factored_;
  Eigen::MatrixXd border_factor_;  // lower triangle
  bool is_eliminated_ = false;     // true if the gradient of `factored_` is that of the estimate
  Values<Dim> estimate_;
  Values<Dim> candidate_;
};

/// Poses and features of a segment in the frame of its first pose, from odometry and first observations.
template <int Dim>
Values<Dim> composed_start(const SegmentView<Dim>& view);

}  // namespace mapjoin
