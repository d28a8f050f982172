// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM the plain way: one dense system with Jacobians by differences, to check the structured solvers against.

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/values.hpp>
#include <numeric>
#include <tests/support/numerical_jacobian.hpp>
#include <vector>

namespace mapjoin::testing {

/// Log of a rotation matrix, apart from the library's rotations.
inline Vector<1> rotation_log(const Matrix<2>& R) {
  return Vector<1>(std::atan2(R(1, 0), R(0, 0)));
}
inline Vector<3> rotation_log(const Matrix<3>& R) {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

/// X̂ - H(X) of the paper's (10) and (11), by rotation matrices.
template <int Dim>
Eigen::VectorXd plain_residual(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target) {
  const Matrix<Dim> R_b = base.rotation.matrix();
  PoseVector<Dim> r;
  r << measured.translation - R_b.transpose() * (target.translation - base.translation),
      rotation_log(Matrix<Dim>((R_b.transpose() * target.rotation.matrix()).transpose() * measured.rotation.matrix()));
  return r;
}
template <int Dim>
Eigen::VectorXd plain_residual(const Point<Dim>& measured, const Pose<Dim>& base, const Point<Dim>& target) {
  return measured - base.rotation.matrix().transpose() * (target - base.translation);
}

/// chi2(x ⊕ δ) ≈ chi2 - 2 gᵀδ + δᵀHδ.
struct DenseEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double chi2 = 0.0;
};

/// Observations over a state of which some poses and features are free; a step has the free poses first, then the free
/// features.
template <int Dim>
struct DenseSlam {
  std::vector<PoseFactor<Dim>> pose_factors;
  std::vector<FeatureFactor<Dim>> feature_factors;
  std::vector<PoseIndex> free_poses;
  std::vector<FeatureIndex> free_features;

  Eigen::Index size() const {
    return static_cast<Eigen::Index>(free_poses.size()) * kPoseDof<Dim> + static_cast<Eigen::Index>(free_features.size()) * Dim;
  }

  Values<Dim> moved(Values<Dim> state, const Eigen::VectorXd& step) const {
    Eigen::Index entry = 0;
    for (const PoseIndex pose : free_poses) {
      auto& value = state.poses[pose];
      value = retract(value, PoseVector<Dim>(step.segment<kPoseDof<Dim>>(entry)));
      entry += kPoseDof<Dim>;
    }
    for (const FeatureIndex feature : free_features) {
      state.features[feature] += step.segment<Dim>(entry);
      entry += Dim;
    }
    return state;
  }

  DenseEquations linearise(const Values<Dim>& state) const {
    DenseEquations equations{Eigen::MatrixXd::Zero(size(), size()), Eigen::VectorXd::Zero(size()), 0.0};
    for (const auto& o : pose_factors) {
      add(o, state.pose(o.base), state.pose(o.target), pose_columns(o.base), pose_columns(o.target), equations);
    }
    for (const auto& o : feature_factors) {
      add(o, state.pose(o.base), state.features[o.target], pose_columns(o.base), feature_columns(o.target), equations);
    }
    return equations;
  }

  /// Gauss-Newton to the last digit; the start must be good.
  Values<Dim> optimum(Values<Dim> state) const {
    for (int k = 0; k < 20; ++k) {
      const DenseEquations equations = linearise(state);
      const Eigen::VectorXd step = equations.H.ldlt().solve(equations.g);
      state = moved(std::move(state), step);
      if (step.norm() < 1e-11) break;
    }
    return state;
  }

 private:
  static Pose<Dim> moved_by(const Pose<Dim>& pose, const Eigen::VectorXd& step) {
    return step.size() == 0 ? pose : retract(pose, PoseVector<Dim>(step));
  }
  static Point<Dim> moved_by(const Point<Dim>& point, const Eigen::VectorXd& step) {
    return step.size() == 0 ? point : Point<Dim>(point + step);
  }

  std::vector<Eigen::Index> pose_columns(PoseIndex pose) const {
    return columns(std::find(free_poses.begin(), free_poses.end(), pose) - free_poses.begin(), free_poses.size(), 0,
                   kPoseDof<Dim>);
  }
  std::vector<Eigen::Index> feature_columns(FeatureIndex feature) const {
    return columns(std::find(free_features.begin(), free_features.end(), feature) - free_features.begin(), free_features.size(),
                   static_cast<Eigen::Index>(free_poses.size()) * kPoseDof<Dim>, Dim);
  }
  static std::vector<Eigen::Index> columns(std::ptrdiff_t place, std::size_t count, Eigen::Index first, int dof) {
    if (place == static_cast<std::ptrdiff_t>(count)) return {};
    std::vector<Eigen::Index> list(static_cast<std::size_t>(dof));
    std::iota(list.begin(), list.end(), first + place * dof);
    return list;
  }

  template <typename Observation, typename Target>
  static void add(const Observation& o, const Pose<Dim>& base, const Target& target, std::vector<Eigen::Index> entries,
                  const std::vector<Eigen::Index>& target_entries, DenseEquations& equations) {
    const Eigen::VectorXd r = plain_residual<Dim>(o.measured, base, target);
    equations.chi2 += r.dot(o.information * r);
    const auto of_base = static_cast<Eigen::Index>(entries.size());
    const auto of_target = static_cast<Eigen::Index>(target_entries.size());
    if (of_base + of_target == 0) return;
    const auto H_of_step = [&](const Eigen::VectorXd& step) {
      return Eigen::VectorXd(
          -plain_residual<Dim>(o.measured, moved_by(base, step.head(of_base)), moved_by(target, step.tail(of_target))));
    };
    const Eigen::MatrixXd J = numerical_jacobian(H_of_step, of_base + of_target, 1e-5);
    entries.insert(entries.end(), target_entries.begin(), target_entries.end());
    equations.H(entries, entries) += J.transpose() * o.information * J;
    equations.g(entries) += J.transpose() * (o.information * r);
  }
};

/// All that a log says; pose 0 is held, or what the World fixes, or nothing where it has priors.
template <int Dim>
DenseSlam<Dim> full_slam(const Log<Dim>& log) {
  DenseSlam<Dim> slam;
  slam.pose_factors = log.graph.pose_factors;
  slam.feature_factors = log.graph.feature_factors;
  const bool world_holds = !log.graph.fixed.empty() || !log.pose_priors().empty() || !log.feature_priors().empty();
  for (const PoseIndex pose : indices(log.poses)) {
    const bool is_fixed = std::any_of(log.graph.fixed.begin(), log.graph.fixed.end(),
                                      [&](const FixedPose<Dim>& fixed) { return fixed.pose == pose; });
    if (!is_fixed && (world_holds || pose > 0)) slam.free_poses.push_back(pose);
  }
  slam.free_features.resize(log.features.size());
  std::iota(slam.free_features.begin(), slam.free_features.end(), FeatureIndex());
  return slam;
}

/// What is left of H and g over the last entries when the first `count` are eliminated.
inline DenseEquations eliminated(const DenseEquations& equations, const std::vector<Eigen::Index>& out,
                                 const std::vector<Eigen::Index>& stay) {
  if (out.empty()) return {equations.H(stay, stay), equations.g(stay), equations.chi2};
  const Eigen::MatrixXd H_os = equations.H(out, stay);
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(Eigen::MatrixXd(equations.H(out, out)));
  const Eigen::VectorXd g_o = equations.g(out);
  return {equations.H(stay, stay) - H_os.transpose() * ldlt.solve(H_os), equations.g(stay) - H_os.transpose() * ldlt.solve(g_o),
          equations.chi2};
}

}  // namespace mapjoin::testing
