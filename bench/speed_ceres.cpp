// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_ceres: full SLAM of a log by Ceres from dead reckoning, as fast as it goes: analytic Jacobians, stopped at the first
// chi2 that is as good as the optimum. What it reached goes to standard output, as JSON.
#include <ceres/ceres.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <filesystem>
#include <map>
#include <mapjoin/io/open.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/linearise.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <tests/support/starts.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// The optimum is reached where chi2 is above it by no more than this share.
constexpr double kAsGood = 1e-6;

struct Arguments {
  std::filesystem::path log;
  double optimum = 0.0;
  ceres::LinearSolverType linear = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres::TrustRegionStrategyType method = ceres::LEVENBERG_MARQUARDT;
  int most_iterations = 1000;
};

/// A pose as Ceres keeps it: x, y, phi, or a translation and a quaternion (w, x, y, z).
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

/// Poses in space by the library's steps. Its Jacobians are with respect to these, whence the identity: the column of a
/// Jacobian that has no step is zero.
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

/// A with AᵀA = W.
template <int Dof>
Matrix<Dof> square_root(const Matrix<Dof>& W) {
  const Eigen::LLT<Matrix<Dof>> cholesky(W);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixU();
  const Eigen::SelfAdjointEigenSolver<Matrix<Dof>> eigen(W);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

/// -A J, as Ceres has it: the residual is X̂ - H(X).
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
template <int Dim>
using PoseCost = Cost<Dim, Pose<Dim>, kPoseDof<Dim>, kPoseSize<Dim>>;
template <int Dim>
using FeatureCost = Cost<Dim, Point<Dim>, Dim, Dim>;

template <int Dim>
class FullSlam {
 public:
  FullSlam(const Log<Dim>& log, const Values<Dim>& start);
  int solve(const Arguments& arguments);
  Values<Dim> state() const;

 private:
  void add(const PoseFactor<Dim>& o) {
    problem_.AddResidualBlock(new PoseCost<Dim>(o.measured, o.information), nullptr, pose(o.base), pose(o.target));
  }
  void add(const FeatureFactor<Dim>& o) {
    problem_.AddResidualBlock(new FeatureCost<Dim>(o.measured, o.information), nullptr, pose(o.base),
                              features_[o.target].data());
  }
  template <typename Observations>
  void add_all(const Observations& observations) {
    for (const auto& o : observations) add(o);
  }
  void add_pose(double* values) {
    problem_.AddParameterBlock(values, kPoseSize<Dim>);
    if constexpr (Dim == 3) problem_.SetManifold(values, &manifold_);
  }
  void hold(PoseIndex index) { problem_.SetParameterBlockConstant(pose(index)); }
  double* pose(PoseIndex index) { return index == kWorld ? world_.data() : poses_[index].data(); }

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
  ceres::Problem problem_{problem_options()};
};

template <int Dim>
FullSlam<Dim>::FullSlam(const Log<Dim>& log, const Values<Dim>& start)
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
  add_all(log.closures());
  add_all(log.observations());
  const bool has_priors = !log.pose_priors().empty() || !log.feature_priors().empty();
  if (has_priors) {
    add_pose(world_.data());
    hold(kWorld);
  }
  add_all(log.pose_priors());
  add_all(log.feature_priors());
  for (const auto& fixed : log.graph.fixed) {
    write(fixed.value, pose(fixed.pose));
    hold(fixed.pose);
  }
  if (log.graph.fixed.empty() && !has_priors) hold(0);
}

/// Ends the solve at the first chi2 that is as good as the optimum.
class StopAtOptimum : public ceres::IterationCallback {
 public:
  explicit StopAtOptimum(double optimum) : cost_(0.5 * optimum * (1.0 + kAsGood)) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    return summary.cost <= cost_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double cost_;
};

/// The number of iterations.
template <int Dim>
int FullSlam<Dim>::solve(const Arguments& arguments) {
  StopAtOptimum stop(arguments.optimum);
  ceres::Solver::Options options;
  options.linear_solver_type = arguments.linear;
  options.trust_region_strategy_type = arguments.method;
  options.max_num_iterations = arguments.most_iterations;
  options.function_tolerance = 1e-10;
  options.gradient_tolerance = 0.0;
  options.parameter_tolerance = 0.0;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  return summary.num_successful_steps + summary.num_unsuccessful_steps;
}

template <int Dim>
Values<Dim> FullSlam<Dim>::state() const {
  Values<Dim> state;
  for (const auto& values : poses_) state.poses.push_back(pose_at<Dim>(values.data()));
  for (const auto& values : features_) state.features.push_back(Point<Dim>::Map(values.data()));
  return state;
}

template <int Dim>
void solve(const Log<Dim>& log, const Arguments& arguments) {
  FullSlam<Dim> problem(log, testing::odometry_start(log));
  const int iterations = problem.solve(arguments);
  const Values<Dim> state = problem.state();
  const nlohmann::json json = {{"chi2", log_chi2(log, state).total()}, {"iterations", iterations}};
  fmt::print("{}\n", json.dump());
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  using mapjoin::Arguments;
  Arguments arguments;
  const std::map<std::string, ceres::LinearSolverType> linear{{"cholesky", ceres::SPARSE_NORMAL_CHOLESKY},
                                                              {"schur", ceres::SPARSE_SCHUR}};
  const std::map<std::string, ceres::TrustRegionStrategyType> methods{{"lm", ceres::LEVENBERG_MARQUARDT},
                                                                      {"dogleg", ceres::DOGLEG}};
  CLI::App app("Full SLAM of a log by Ceres, from dead reckoning to a chi2 as good as the optimum.", "mapjoin_ceres");
  app.add_option("log", arguments.log, "The log")->required();
  app.add_option("--optimum", arguments.optimum, "The chi2 to reach; 0: what it converges to")->capture_default_str();
  app.add_option("--linear", arguments.linear, "cholesky or schur")->transform(CLI::CheckedTransformer(linear));
  app.add_option("--method", arguments.method, "lm or dogleg")->transform(CLI::CheckedTransformer(methods));
  app.add_option("--iterations", arguments.most_iterations, "At most so many")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto log = mapjoin::open_log(arguments.log);
  if (!log) {
    fmt::print(stderr, "mapjoin_ceres: {}\n", log.error().message);
    return 3;
  }
  std::visit([&](const auto& any) { mapjoin::solve(any, arguments); }, *log);
  return 0;
}
