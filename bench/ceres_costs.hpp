// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The poses, observations and losses of a log for Ceres, with the library's residuals and steps.

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin::bench {

/// The size of a pose as Ceres keeps it: x, y, phi, or a translation and a quaternion (w, x, y, z).
template <int Dim>
inline constexpr int kPoseSize = Dim == 2 ? 3 : 7;
template <int Dim>
using PoseArray = std::array<double, kPoseSize<Dim>>;

inline void write(const Pose<2>& pose, double* values) {
  Point<2>::Map(values) = pose.translation;
  values[2] = pose.rotation.angle();
}
inline void write(const Pose<3>& pose, double* values) {
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

}  // namespace mapjoin::bench
