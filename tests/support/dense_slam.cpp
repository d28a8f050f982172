// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tests/support/dense_slam.hpp>
#include <tests/support/numerical_jacobian.hpp>
#include <utility>

namespace mapjoin::testing {
namespace {

/// The Log of a rotation matrix, computed without the library's rotations.
Vector<1> rotation_log(const Matrix<2>& R) {
  return Vector<1>(std::atan2(R(1, 0), R(0, 0)));
}
Vector<3> rotation_log(const Matrix<3>& R) {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

template <int Dim>
Pose<Dim> moved_by(const Pose<Dim>& pose, const Eigen::VectorXd& step) {
  return step.size() == 0 ? pose : retract(pose, PoseVector<Dim>(step));
}
template <int Dim>
Point<Dim> moved_by(const Point<Dim>& point, const Eigen::VectorXd& step) {
  return step.size() == 0 ? point : Point<Dim>(point + step);
}

/// The entries of a step that move `one` of the `free` variables, whose entries begin at `first`; none if it is not free.
template <typename Index>
std::vector<Eigen::Index> entries_of(Index one, const std::vector<Index>& free, Eigen::Index first, int dof) {
  const auto place = std::ranges::find(free, one) - free.begin();
  if (place == std::ssize(free)) return {};
  std::vector<Eigen::Index> entries(static_cast<std::size_t>(dof));
  std::iota(entries.begin(), entries.end(), first + place * dof);
  return entries;
}

template <int Dim, typename Observation, typename Target>
void add(const Observation& o, const Pose<Dim>& base, const Target& target, std::vector<Eigen::Index> entries,
         const std::vector<Eigen::Index>& target_entries, DenseEquations& equations) {
  const Eigen::VectorXd r = plain_residual<Dim>(o.measured, base, target);
  equations.chi2 += r.dot(o.information * r);
  const auto of_base = static_cast<Eigen::Index>(entries.size());
  const auto of_target = static_cast<Eigen::Index>(target_entries.size());
  if (of_base + of_target == 0) return;
  const auto H_of_step = [&](const Eigen::VectorXd& step) {
    return Eigen::VectorXd(
        -plain_residual<Dim>(o.measured, moved_by<Dim>(base, step.head(of_base)), moved_by<Dim>(target, step.tail(of_target))));
  };
  const Eigen::MatrixXd J = numerical_jacobian(H_of_step, of_base + of_target, 1e-5);
  entries.insert(entries.end(), target_entries.begin(), target_entries.end());
  equations.H(entries, entries) += J.transpose() * o.information * J;
  equations.g(entries) += J.transpose() * (o.information * r);
}

}  // namespace

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

template <int Dim>
Eigen::Index DenseSlam<Dim>::size() const {
  return std::ssize(free_poses) * kPoseDof<Dim> + std::ssize(free_features) * Dim;
}

template <int Dim>
Values<Dim> DenseSlam<Dim>::moved(Values<Dim> state, const Eigen::VectorXd& step) const {
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

template <int Dim>
DenseEquations DenseSlam<Dim>::linearise(const Values<Dim>& state) const {
  DenseEquations equations{Eigen::MatrixXd::Zero(size(), size()), Eigen::VectorXd::Zero(size()), 0.0};
  const auto pose_entries = [&](PoseIndex pose) { return entries_of(pose, free_poses, 0, kPoseDof<Dim>); };
  const auto feature_entries = [&](FeatureIndex feature) {
    return entries_of(feature, free_features, std::ssize(free_poses) * kPoseDof<Dim>, Dim);
  };
  for (const auto& o : pose_factors) {
    add<Dim>(o, state.pose(o.base), state.pose(o.target), pose_entries(o.base), pose_entries(o.target), equations);
  }
  for (const auto& o : feature_factors) {
    add<Dim>(o, state.pose(o.base), state.features[o.target], pose_entries(o.base), feature_entries(o.target), equations);
  }
  return equations;
}

template <int Dim>
Values<Dim> DenseSlam<Dim>::optimum(Values<Dim> state) const {
  for (int k = 0; k < 20; ++k) {
    const DenseEquations equations = linearise(state);
    const Eigen::VectorXd step = equations.H.ldlt().solve(equations.g);
    state = moved(std::move(state), step);
    if (step.norm() < 1e-11) break;
  }
  return state;
}

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

DenseEquations eliminated(const DenseEquations& equations, const std::vector<Eigen::Index>& out,
                          const std::vector<Eigen::Index>& stay) {
  if (out.empty()) return {equations.H(stay, stay), equations.g(stay), equations.chi2};
  const Eigen::MatrixXd H_os = equations.H(out, stay);
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(Eigen::MatrixXd(equations.H(out, out)));
  const Eigen::VectorXd g_o = equations.g(out);
  return {equations.H(stay, stay) - H_os.transpose() * ldlt.solve(H_os), equations.g(stay) - H_os.transpose() * ldlt.solve(g_o),
          equations.chi2};
}

template Eigen::VectorXd plain_residual<2>(const Pose<2>&, const Pose<2>&, const Pose<2>&);
template Eigen::VectorXd plain_residual<2>(const Point<2>&, const Pose<2>&, const Point<2>&);
template struct DenseSlam<2>;
template DenseSlam<2> full_slam(const Log<2>&);
template Eigen::VectorXd plain_residual<3>(const Pose<3>&, const Pose<3>&, const Pose<3>&);
template Eigen::VectorXd plain_residual<3>(const Point<3>&, const Pose<3>&, const Point<3>&);
template struct DenseSlam<3>;
template DenseSlam<3> full_slam(const Log<3>&);

}  // namespace mapjoin::testing
