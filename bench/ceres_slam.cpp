// SPDX-License-Identifier: BSD-3-Clause
#include "ceres_slam.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <deque>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin::bench {
namespace {

/// The size of a pose as Ceres keeps it: x, y, phi, or a translation and a quaternion (w, x, y, z).
template <int Dim>
inline constexpr int kPoseSize = Dim == 2 ? 3 : 7;
template <int Dim>
using PoseArray = std::array<double, kPoseSize<Dim>>;

void write(const Pose<2>& pose, double* values) {
  Point<2>::Map(values) = pose.translation;
  values[2] = pose.rotation.angle();
}
void write(const Pose<3>& pose, double* values) {
  Point<3>::Map(values) = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  Vector<4>::Map(values + 3) << q.w(), q.x(), q.y(), q.z();
}
template <int Dim>
Pose<Dim> pose_at(const double* values) {
  const Point<Dim> translation = Point<Dim>::Map(values);
  if constexpr (Dim == 2) {
    return {translation, Rotation<2>(values[2])};
  } else {
    return {translation, Rotation<3>(Eigen::Quaterniond(values[3], values[4], values[5], values[6]))};
  }
}

/// Poses in space with the library's steps. Costs write their Jacobians with respect to these, with a last column of zeros, so
/// that the Jacobian of the manifold is the identity.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize<3>; }
  int TangentSize() const override { return kPoseDof<3>; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    write(retract<3>(pose_at<3>(x), PoseVector<3>::Map(delta)), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseSize<3>, kPoseDof<3>, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    PoseVector<3>::Map(y_minus_x) = local<3>(pose_at<3>(x), pose_at<3>(y));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kPoseDof<3>, kPoseSize<3>, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
};

/// The matrix A with AᵀA = W.
template <int Dof>
Matrix<Dof> square_root(const Matrix<Dof>& W) {
  const Eigen::LLT<Matrix<Dof>> cholesky(W);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Matrix<Dof>> eigen(W);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

/// Writes -A J, as Ceres has it: the residual is X̂ - H(X).
template <int Dof, int Size, typename Jacobian>
void write_jacobian(const Matrix<Dof>& root, const Jacobian& J, double* jacobian) {
  Eigen::Map<Eigen::Matrix<double, Dof, Size, Eigen::RowMajor>> out(jacobian);
  if constexpr (Size > Jacobian::ColsAtCompileTime) out.setZero();
  out.template leftCols<Jacobian::ColsAtCompileTime>().noalias() = -root * J;
}

/// The whitened residual of one observation and its Jacobians; `Target` is a pose or a point.
template <int Dim, typename Target, int Dof, int TargetSize>
class Cost : public ceres::SizedCostFunction<Dof, kPoseSize<Dim>, TargetSize> {
 public:
  Cost(const Target& measured, const Matrix<Dof>& information) : measured_(measured), root_(square_root(information)) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Pose<Dim> base = pose_at<Dim>(parameters[0]);
    const Target target = target_at(parameters[1]);
    if (!jacobians) {
      Vector<Dof>::Map(residuals).noalias() = root_ * residual<Dim>(measured_, base, target);
      return true;
    }
    const auto linear = linearise<Dim>(measured_, base, target);
    Vector<Dof>::Map(residuals).noalias() = root_ * linear.residual;
    if (jacobians[0]) write_jacobian<Dof, kPoseSize<Dim>>(root_, linear.J_base, jacobians[0]);
    if (jacobians[1]) write_jacobian<Dof, TargetSize>(root_, linear.J_target, jacobians[1]);
    return true;
  }

 private:
  static Target target_at(const double* values) {
    if constexpr (TargetSize == Dim) {
      return Point<Dim>::Map(values);
    } else {
      return pose_at<Dim>(values);
    }
  }

  Target measured_;
  Matrix<Dof> root_;
};

/// The whitened residual of one observation, scaled by a switch variable (Sünderhauf and Protzel, IROS 2012).
template <int Dim, typename Target, int Dof, int TargetSize>
class SwitchedCost : public ceres::SizedCostFunction<Dof, kPoseSize<Dim>, TargetSize, 1> {
 public:
  SwitchedCost(const Target& measured, const Matrix<Dof>& information) : cost_(measured, information) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    cost_.Evaluate(parameters, residuals, jacobians);
    const double s = *parameters[2];
    Eigen::Map<Vector<Dof>> r(residuals);
    if (jacobians) {
      if (jacobians[0]) Eigen::Map<Eigen::Matrix<double, Dof, kPoseSize<Dim>, Eigen::RowMajor>>(jacobians[0]) *= s;
      if (jacobians[1]) Eigen::Map<Eigen::Matrix<double, Dof, TargetSize, Eigen::RowMajor>>(jacobians[1]) *= s;
      if (jacobians[2]) Vector<Dof>::Map(jacobians[2]) = r;
    }
    r *= s;
    return true;
  }

 private:
  Cost<Dim, Target, Dof, TargetSize> cost_;
};

/// Pulls a switch variable to 1, with a standard deviation of 1.
class SwitchPrior : public ceres::SizedCostFunction<1, 1> {
 public:
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = 1.0 - *parameters[0];
    if (jacobians && jacobians[0]) *jacobians[0] = -1.0;
    return true;
  }
};

/// The loss ρ(s) = s / (1 + s).
class GemanMcClureLoss : public ceres::LossFunction {
 public:
  void Evaluate(double s, double* rho) const override {
    const double shrink = 1.0 / (1.0 + s);
    rho[0] = s * shrink;
    rho[1] = shrink * shrink;
    rho[2] = -2.0 * rho[1] * shrink;
  }
};

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
  return summary.num_successful_steps + summary.num_unsuccessful_steps;
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
