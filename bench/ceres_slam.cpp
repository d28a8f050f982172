// SPDX-License-Identifier: BSD-3-Clause
#include "ceres_slam.hpp"

#include <algorithm>
#include <deque>

#include "ceres_costs.hpp"

namespace mapjoin::bench {
namespace {

ceres::LossFunction* make_loss(CeresLoss loss) {
  switch (loss) {
    case CeresLoss::kCauchy:
      return new ceres::CauchyLoss(1.0);
    case CeresLoss::kGemanMcClure:
      return new GemanMcClureLoss;
    default:
      return nullptr;
  }
}

template <int Dim>
class FullSlam {
 public:
  FullSlam(const Log<Dim>& log, const Values<Dim>& start, CeresLoss loss);
  int solve(const CeresOptions& options);
  Values<Dim> values() const;

 private:
  template <template <int, typename, int, int> typename Kind>
  static auto* cost(const PoseFactor<Dim>& o) {
    return new Kind<Dim, Pose<Dim>, kPoseDof<Dim>, kPoseSize<Dim>>(o.measured, o.information);
  }
  template <template <int, typename, int, int> typename Kind>
  static auto* cost(const FeatureFactor<Dim>& o) {
    return new Kind<Dim, Point<Dim>, Dim, Dim>(o.measured, o.information);
  }
  template <typename Observations>
  void add_all(const Observations& observations, ceres::LossFunction* loss = nullptr) {
    for (const auto& o : observations) problem_.AddResidualBlock(cost<Cost>(o), loss, values_of(o.base), values_of(o.target));
  }
  template <typename Observations>
  void add_switched(const Observations& observations) {
    for (const auto& o : observations) {
      double* switch_value = &switches_.emplace_back(1.0);
      problem_.AddResidualBlock(cost<SwitchedCost>(o), nullptr, values_of(o.base), values_of(o.target), switch_value);
      problem_.AddResidualBlock(new SwitchPrior, nullptr, switch_value);
      problem_.SetParameterLowerBound(switch_value, 0, 0.0);
      problem_.SetParameterUpperBound(switch_value, 0, 1.0);
    }
  }
  void add_pose(double* values) {
    problem_.AddParameterBlock(values, kPoseSize<Dim>);
    if constexpr (Dim == 3) problem_.SetManifold(values, &manifold_);
  }
  void hold(PoseIndex index) { problem_.SetParameterBlockConstant(values_of(index)); }
  double* values_of(PoseIndex index) { return index == kWorld ? world_.data() : poses_[index].data(); }
  double* values_of(FeatureIndex index) { return features_[index].data(); }

  static ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;
    return options;
  }

  PoseManifold manifold_;
  PoseArray<Dim> world_{};
  Table<PoseIndex, PoseArray<Dim>> poses_;
  Table<FeatureIndex, std::array<double, Dim>> features_;
  std::deque<double> switches_;  // a deque, in which they stay where they are
  ceres::Problem problem_{problem_options()};
};

template <int Dim>
FullSlam<Dim>::FullSlam(const Log<Dim>& log, const Values<Dim>& start, CeresLoss loss)
    : poses_(start.poses.size()), features_(start.features.size()) {
  write(Pose<Dim>{}, world_.data());
  for (const PoseIndex p : indices(poses_)) {
    write(start.poses[p], poses_[p].data());
    add_pose(poses_[p].data());
  }
  for (const FeatureIndex f : indices(features_)) {
    Point<Dim>::Map(features_[f].data()) = start.features[f];
    problem_.AddParameterBlock(features_[f].data(), Dim);
  }
  add_all(log.odometry());
  if (loss == CeresLoss::kSwitchable) {
    add_switched(log.closures());
    add_switched(log.observations());
  } else {
    add_all(log.closures(), make_loss(loss));
    add_all(log.observations(), make_loss(loss));
  }
  const bool has_priors = !log.pose_priors().empty() || !log.feature_priors().empty();
  if (has_priors) {
    add_pose(world_.data());
    hold(kWorld);
  }
  add_all(log.pose_priors());
  add_all(log.feature_priors());
  for (const auto& fixed : log.graph.fixed) {
    write(fixed.value, values_of(fixed.pose));
    hold(fixed.pose);
  }
  if (log.graph.fixed.empty() && !has_priors) hold(0);
}

/// Ends the solve at the first chi2 that is good enough.
class StopAtCost : public ceres::IterationCallback {
 public:
  explicit StopAtCost(double cost) : cost_(cost) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    return summary.cost <= cost_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double cost_;
};

/// Solves; returns the number of iterations.
template <int Dim>
int FullSlam<Dim>::solve(const CeresOptions& options) {
  StopAtCost stop(0.5 * options.enough_chi2);
  ceres::Solver::Options solver;
  solver.linear_solver_type = options.linear;
  solver.trust_region_strategy_type = options.method;
  solver.max_num_iterations = options.most_iterations;
  solver.max_solver_time_in_seconds = options.most_seconds;
  solver.function_tolerance = 1e-10;
  solver.gradient_tolerance = 0.0;
  solver.parameter_tolerance = 0.0;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem_, &summary);
  return std::max(0, summary.num_successful_steps + summary.num_unsuccessful_steps - 1);  // Ceres counts the start, too
}

template <int Dim>
Values<Dim> FullSlam<Dim>::values() const {
  Values<Dim> values;
  for (const auto& pose : poses_) values.poses.push_back(pose_at<Dim>(pose.data()));
  for (const auto& feature : features_) values.features.push_back(Point<Dim>::Map(feature.data()));
  return values;
}

}  // namespace

template <int Dim>
CeresResult<Dim> solve_by_ceres(const Log<Dim>& log, const Values<Dim>& start, const CeresOptions& options) {
  FullSlam<Dim> problem(log, start, options.loss);
  const int iterations = problem.solve(options);
  return {problem.values(), iterations};
}

template CeresResult<2> solve_by_ceres(const Log<2>&, const Values<2>&, const CeresOptions&);
template CeresResult<3> solve_by_ceres(const Log<3>&, const Values<3>&, const CeresOptions&);

}  // namespace mapjoin::bench
