// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <tests/support/ceres_reference.hpp>

namespace mapjoin::testing {
namespace {

/// The number of Ceres' parameters of a rotation: its heading in the plane, its quaternion (w, x, y, z) in space.
template <int Dim>
inline constexpr int kRotationSize = Dim == 2 ? 1 : 4;

template <int Dim>
struct Parameters {
  Table<PoseIndex, std::array<double, Dim>> translations;
  Table<PoseIndex, std::array<double, kRotationSize<Dim>>> rotations;
  Table<FeatureIndex, std::array<double, Dim>> features;
};

std::array<double, 1> to_array(const Rotation<2>& rotation) {
  return {rotation.angle()};
}
std::array<double, 4> to_array(const Rotation<3>& rotation) {
  const Eigen::Quaterniond& q = rotation.quaternion();
  return {q.w(), q.x(), q.y(), q.z()};
}
Rotation<2> to_rotation(const std::array<double, 1>& a) {
  return Rotation<2>(a[0]);
}
Rotation<3> to_rotation(const std::array<double, 4>& a) {
  return Rotation<3>(Eigen::Quaterniond(a[0], a[1], a[2], a[3]).normalized());
}
template <int Dim>
std::array<double, Dim> to_array(const Point<Dim>& p) {
  std::array<double, Dim> a;
  Point<Dim>::Map(a.data()) = p;
  return a;
}

/// A square root A of W: AᵀA = W.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& W) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(W);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

/// The point `p` turned by the inverse of `rotation`.
template <typename T>
std::array<T, 2> turned_back(const T* rotation, const std::array<T, 2>& p) {
  using std::cos, std::sin;
  const T c = cos(rotation[0]);
  const T s = sin(rotation[0]);
  return {c * p[0] + s * p[1], c * p[1] - s * p[0]};
}
template <typename T>
std::array<T, 3> turned_back(const T* rotation, const std::array<T, 3>& p) {
  const T conjugate[4] = {rotation[0], -rotation[1], -rotation[2], -rotation[3]};
  std::array<T, 3> turned;
  ceres::UnitQuaternionRotatePoint(conjugate, p.data(), turned.data());
  return turned;
}

/// The point `p` turned by `rotation`.
template <typename T>
std::array<T, 2> turned(const T* rotation, const std::array<double, 2>& p) {
  using std::cos, std::sin;
  const T c = cos(rotation[0]);
  const T s = sin(rotation[0]);
  return {c * p[0] - s * p[1], s * p[0] + c * p[1]};
}
template <typename T>
std::array<T, 3> turned(const T* rotation, const std::array<double, 3>& p) {
  const T point[3] = {T(p[0]), T(p[1]), T(p[2])};
  std::array<T, 3> out;
  ceres::UnitQuaternionRotatePoint(rotation, point, out.data());
  return out;
}

/// Writes the rotation part of the residual, Log((R_bᵀ R_t)ᵀ R̂), to `error`.
template <typename T>
void rotation_error(const std::array<double, 1>& measured, const T* base, const T* target, T* error) {
  using std::floor;
  const T angle = measured[0] - (target[0] - base[0]);
  error[0] = angle - 2.0 * M_PI * floor((angle + M_PI) / (2.0 * M_PI));
}
template <typename T>
void rotation_error(const std::array<double, 4>& measured, const T* base, const T* target, T* error) {
  const T target_conjugate[4] = {target[0], -target[1], -target[2], -target[3]};
  const T measured_q[4] = {T(measured[0]), T(measured[1]), T(measured[2]), T(measured[3])};
  T target_base[4];
  T difference[4];
  ceres::QuaternionProduct(target_conjugate, base, target_base);
  ceres::QuaternionProduct(target_base, measured_q, difference);
  ceres::QuaternionToAngleAxis(difference, error);
}

/// The whitened residual of a local map. Parameters: translation and rotation of the base (unless it is the World) and of each
/// kept pose, then the features.
template <int Dim>
class MapError {
 public:
  /// Takes the positions of poses as measured at the end of `lever`.
  MapError(const LocalMap<Dim>& map, const Point<Dim>& lever)
      : root_(square_root(map.information)), from_world_(map.base == kWorld), lever_(to_array<Dim>(lever)) {
    for (const Pose<Dim>& pose : map.pose_estimates) {
      poses_.emplace_back(to_array<Dim>(pose.translation), to_array(pose.rotation));
    }
    for (const Point<Dim>& p : map.feature_estimates) features_.push_back(to_array<Dim>(p));
  }

  template <typename T>
  bool operator()(T const* const* parameters, T* residual) const {
    const auto origin = [] {
      std::array<T, kRotationSize<Dim>> rotation;
      rotation.fill(T(0.0));
      if (Dim == 3) rotation[0] = T(1.0);
      return rotation;
    }();
    const std::array<T, Dim> zero = [] {
      std::array<T, Dim> translation;
      translation.fill(T(0.0));
      return translation;
    }();
    const T* t_base = from_world_ ? zero.data() : *parameters++;
    const T* R_base = from_world_ ? origin.data() : *parameters++;

    Eigen::Matrix<T, Eigen::Dynamic, 1> r(root_.rows());
    T* row = r.data();
    for (const auto& [translation, rotation] : poses_) {
      const T* t_target = *parameters++;
      const T* R_target = *parameters++;
      std::array<T, Dim> end = turned(R_target, lever_);
      for (std::size_t i = 0; i < Dim; ++i) end[i] += t_target[i];
      row = position_error(translation, t_base, R_base, end.data(), row);
      rotation_error(rotation, R_base, R_target, row);
      row += kRotationDof<Dim>;
    }
    for (const auto& feature : features_) row = position_error(feature, t_base, R_base, *parameters++, row);
    Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, 1>>(residual, root_.rows()) = root_.template cast<T>() * r;
    return true;
  }

 private:
  template <typename T>
  static T* position_error(const std::array<double, Dim>& measured, const T* t_base, const T* R_base, const T* t_target,
                           T* error) {
    std::array<T, Dim> offset;
    for (std::size_t i = 0; i < Dim; ++i) offset[i] = t_target[i] - t_base[i];
    const std::array<T, Dim> expected = turned_back(R_base, offset);
    for (std::size_t i = 0; i < Dim; ++i) error[i] = measured[i] - expected[i];
    return error + Dim;
  }

  Eigen::MatrixXd root_;
  bool from_world_;
  std::array<double, Dim> lever_;
  std::vector<std::pair<std::array<double, Dim>, std::array<double, kRotationSize<Dim>>>> poses_;
  std::vector<std::array<double, Dim>> features_;
};

template <int Dim>
class Problem {
 public:
  explicit Problem(const Values<Dim>& start) {
    for (const Pose<Dim>& pose : start.poses) {
      parameters_.translations.push_back(to_array<Dim>(pose.translation));
      parameters_.rotations.push_back(to_array(pose.rotation));
    }
    for (const Point<Dim>& p : start.features) parameters_.features.push_back(to_array<Dim>(p));
    for (auto& t : parameters_.translations) problem_.AddParameterBlock(t.data(), Dim);
    for (auto& R : parameters_.rotations) {
      problem_.AddParameterBlock(R.data(), kRotationSize<Dim>);
      if constexpr (Dim == 3) problem_.SetManifold(R.data(), new ceres::QuaternionManifold);
    }
    for (auto& p : parameters_.features) problem_.AddParameterBlock(p.data(), Dim);
  }

  void add(const LocalMap<Dim>& map, const Point<Dim>& lever = Point<Dim>::Zero()) {
    auto* cost = new ceres::DynamicAutoDiffCostFunction<MapError<Dim>, 4>(new MapError<Dim>(map, lever));
    std::vector<double*> blocks;
    const auto depend_on = [&](double* block, int size) {
      blocks.push_back(block);
      cost->AddParameterBlock(size);
    };
    const auto depend_on_pose = [&](PoseIndex pose) {
      depend_on(translation(pose), Dim);
      depend_on(rotation(pose), kRotationSize<Dim>);
    };
    if (map.base != kWorld) depend_on_pose(map.base);
    for (const PoseIndex pose : map.poses) depend_on_pose(pose);
    for (const FeatureIndex feature : map.features) depend_on(parameters_.features[feature].data(), Dim);
    cost->SetNumResiduals(static_cast<int>(map.information.rows()));
    problem_.AddResidualBlock(cost, nullptr, blocks);
  }

  void add(const PoseFactor<Dim>& o) { add(LocalMap<Dim>{o.base, {o.target}, {}, {o.measured}, {}, o.information}, o.lever); }
  void add(const FeatureFactor<Dim>& o) { add(LocalMap<Dim>{o.base, {}, {o.target}, {}, {o.measured}, o.information}); }
  template <typename Item>
  void add(const std::vector<Item>& items) {
    for (const Item& item : items) add(item);
  }

  void hold(PoseIndex pose) {
    problem_.SetParameterBlockConstant(translation(pose));
    problem_.SetParameterBlockConstant(rotation(pose));
  }
  void hold(const FixedPose<Dim>& fixed) {
    parameters_.translations[fixed.pose] = to_array<Dim>(fixed.value.translation);
    parameters_.rotations[fixed.pose] = to_array(fixed.value.rotation);
    hold(fixed.pose);
  }

  ReferenceResult<Dim> solve(const ReferenceOptions& options);

 private:
  double* translation(PoseIndex pose) { return parameters_.translations[pose].data(); }
  double* rotation(PoseIndex pose) { return parameters_.rotations[pose].data(); }

  Parameters<Dim> parameters_;
  ceres::Problem problem_;
};

template <int Dim>
Values<Dim> to_values(const Parameters<Dim>& parameters) {
  Values<Dim> values;
  for (const PoseIndex i : indices(parameters.translations)) {
    values.poses.push_back({Point<Dim>::Map(parameters.translations[i].data()), to_rotation(parameters.rotations[i])});
  }
  for (const auto& p : parameters.features) values.features.push_back(Point<Dim>::Map(p.data()));
  return values;
}

template <int Dim>
ReferenceResult<Dim> Problem<Dim>::solve(const ReferenceOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.trust_region_strategy_type =
      options.method == ReferenceMethod::kDogleg ? ceres::DOGLEG : ceres::LEVENBERG_MARQUARDT;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = 0.0;
  ceres_options.parameter_tolerance = 1e-14;
  ceres_options.minimizer_progress_to_stdout = options.verbose;
  ceres_options.logging_type = options.verbose ? ceres::PER_MINIMIZER_ITERATION : ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem_, &summary);
  return {.converged = summary.termination_type == ceres::CONVERGENCE,
          .iterations = std::max(0, summary.num_successful_steps + summary.num_unsuccessful_steps - 1),  // without the start
          .initial_chi2 = 2.0 * summary.initial_cost,
          .chi2 = 2.0 * summary.final_cost,
          .values = to_values(parameters_),
          .summary = summary.BriefReport()};
}

}  // namespace

template <int Dim>
ReferenceResult<Dim> ceres_optimum(const Log<Dim>& log, const Values<Dim>& start, const ReferenceOptions& options) {
  Problem<Dim> problem(start);
  problem.add(log.graph.pose_factors);
  problem.add(log.graph.feature_factors);
  for (const auto& fixed : log.graph.fixed) problem.hold(fixed);
  if (log.graph.fixed.empty() && log.pose_priors().empty() && log.feature_priors().empty()) problem.hold(PoseIndex(0));
  return problem.solve(options);
}

template <int Dim>
ReferenceResult<Dim> ceres_optimum(const SubmapSet<Dim>& set, const Values<Dim>& start, const ReferenceOptions& options) {
  Problem<Dim> problem(start);
  problem.add(set.graph.submaps);
  problem.add(set.graph.pose_factors);
  problem.add(set.graph.feature_factors);
  for (const auto& fixed : set.graph.fixed) problem.hold(fixed);
  const auto from_world = [](const auto& item) { return item.base == kWorld; };
  if (set.graph.fixed.empty() && std::none_of(set.graph.submaps.begin(), set.graph.submaps.end(), from_world) &&
      std::none_of(set.graph.pose_factors.begin(), set.graph.pose_factors.end(), from_world) &&
      std::none_of(set.graph.feature_factors.begin(), set.graph.feature_factors.end(), from_world)) {
    problem.hold(PoseIndex(0));
  }
  return problem.solve(options);
}

template ReferenceResult<2> ceres_optimum(const Log<2>&, const Values<2>&, const ReferenceOptions&);
template ReferenceResult<3> ceres_optimum(const Log<3>&, const Values<3>&, const ReferenceOptions&);
template ReferenceResult<2> ceres_optimum(const SubmapSet<2>&, const Values<2>&, const ReferenceOptions&);
template ReferenceResult<3> ceres_optimum(const SubmapSet<3>&, const Values<3>&, const ReferenceOptions&);

}  // namespace mapjoin::testing
