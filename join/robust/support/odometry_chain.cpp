// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/model/information.hpp>
#include <numbers>
#include <utility>

namespace mapjoin {
namespace {

/// ∂(step of the pose, as retract() takes it)/∂(twist on its left).
template <int Dim>
PoseMatrix<Dim> step_of_twist(const Pose<Dim>& pose) {
  constexpr int kRot = kRotationDof<Dim>;
  PoseMatrix<Dim> J = PoseMatrix<Dim>::Identity();
  J.template topRightCorner<Dim, kRot>() = J_turned_rotation(pose.translation);
  if constexpr (Dim == 3) J.template bottomRightCorner<kRot, kRot>() = pose.rotation.matrix().transpose();
  return J;
}

}  // namespace

template <int Dim>
PoseMatrix<Dim> adjoint(const Pose<Dim>& pose) {
  constexpr int kRot = kRotationDof<Dim>;
  const PointMatrix<Dim> R = pose.rotation.matrix();
  PoseMatrix<Dim> Ad = PoseMatrix<Dim>::Identity();
  Ad.template topLeftCorner<Dim, Dim>() = R;
  Ad.template topRightCorner<Dim, kRot>() = -J_turned_rotation(pose.translation);
  if constexpr (Dim == 3) {
    Ad.template topRightCorner<Dim, kRot>() *= R;
    Ad.template bottomRightCorner<kRot, kRot>() = R;
  }
  return Ad;
}

template <int Dim>
UncertainPose<Dim> compose(const UncertainPose<Dim>& a, const UncertainPose<Dim>& b) {
  const PoseMatrix<Dim> Ad = adjoint(a.mean);
  return {compose(a.mean, b.mean), a.covariance + Ad * b.covariance * Ad.transpose()};
}

template <int Dim>
UncertainPose<Dim> inverse(const UncertainPose<Dim>& a) {
  const Pose<Dim> mean = inverse(a.mean);
  const PoseMatrix<Dim> Ad = adjoint(mean);
  return {mean, Ad * a.covariance * Ad.transpose()};
}

template <int Dim>
PoseVector<Dim> information_within(double extent) {
  PoseVector<Dim> information = PoseVector<Dim>::Constant(1.0 / kSquaredTurn);
  information.template head<Dim>().setConstant(1.0 / (extent * extent));
  return information;
}

template <int Dim>
PoseFactor<Dim> completed(PoseFactor<Dim> edge, double extent) {
  if (information_rank(edge.information) == kPoseDof<Dim>) return edge;
  edge.information.diagonal() += information_within<Dim>(extent);
  return edge;
}

template <int Dim>
UncertainPose<Dim> uncertain(const PoseFactor<Dim>& observation) {
  const PoseMatrix<Dim> J = step_of_twist(observation.measured).inverse();
  return {observation.measured, J * covariance_of(observation.information) * J.transpose()};
}

template <int Dim>
UncertainPose<Dim> forwards(const PoseFactor<Dim>& edge) {
  return edge.base < edge.target ? uncertain(edge) : inverse(uncertain(edge));
}

template <int Dim>
UncertainPose<Dim> fused(const UncertainPose<Dim>& a, const UncertainPose<Dim>& b) {
  const Eigen::LLT<PoseMatrix<Dim>> of_difference(a.covariance + b.covariance);
  const PoseVector<Dim> twist = local(Pose<Dim>{}, compose(b.mean, inverse(a.mean)));
  return {compose(retract(Pose<Dim>{}, PoseVector<Dim>(a.covariance * of_difference.solve(twist))), a.mean),
          a.covariance * of_difference.solve(b.covariance)};
}

template <int Dim>
OdometryChain<Dim>::OdometryChain(const Log<Dim>& log) : sessions_(log.poses.size()), poses_(log.poses.size()) {
  for (std::size_t k = 0; k < log.sessions.size(); ++k) {
    for (PoseIndex p = log.sessions[k].begin; p < log.sessions[k].end; ++p) sessions_[p] = k;
  }
  const auto odometry = log.odometry();
  for (auto edge = odometry.begin(); edge != odometry.end();) {
    const auto [before, after] = std::minmax(edge->base, edge->target);
    UncertainPose<Dim> step = forwards(*edge);
    for (++edge; edge != odometry.end() && later_pose(*edge) == after; ++edge) {
      step = fused(step, forwards(*edge));
    }
    poses_[after] = compose(poses_[before], step);
  }
}

template <int Dim>
UncertainPose<Dim> OdometryChain<Dim>::relative(PoseIndex base, PoseIndex target) const {
  const auto [before, after] = std::minmax(base, target);
  const Pose<Dim> to_base = inverse(poses_[base].mean);
  const PoseMatrix<Dim> Ad = adjoint(to_base);
  return {compose(to_base, poses_[target].mean), Ad * (poses_[after].covariance - poses_[before].covariance) * Ad.transpose()};
}

template <int Dim>
std::vector<Eigen::AlignedBox<double, Dim>> OdometryChain<Dim>::boxes() const {
  std::vector<Eigen::AlignedBox<double, Dim>> boxes(sessions_.empty() ? 0 : sessions_.back() + 1);
  for (const PoseIndex p : indices(poses_)) boxes[sessions_[p]].extend(poses_[p].mean.translation);
  return boxes;
}

template <int Dim>
double OdometryChain<Dim>::volume() const {
  double largest = 0.0;
  for (const auto& box : boxes()) largest = std::max(largest, box.sizes().cwiseMax(1.0).prod());
  return largest * kVolumeOfRotations<Dim>;
}

template <int Dim>
double OdometryChain<Dim>::extent() const {
  double longest = 1.0;
  for (const auto& box : boxes()) longest = std::max(longest, box.sizes().maxCoeff());
  return longest;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                             \
  template PoseMatrix<Dim> adjoint(const Pose<Dim>&);                                        \
  template UncertainPose<Dim> compose(const UncertainPose<Dim>&, const UncertainPose<Dim>&); \
  template UncertainPose<Dim> inverse(const UncertainPose<Dim>&);                            \
  template PoseVector<Dim> information_within<Dim>(double);                                  \
  template PoseFactor<Dim> completed(PoseFactor<Dim>, double);                               \
  template UncertainPose<Dim> uncertain(const PoseFactor<Dim>&);                             \
  template UncertainPose<Dim> forwards(const PoseFactor<Dim>&);                              \
  template UncertainPose<Dim> fused(const UncertainPose<Dim>&, const UncertainPose<Dim>&);   \
  template class OdometryChain<Dim>;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
