// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Observations of one target from one base: odometry, closures and priors (a pose), feature observations (a point).
//
// Every observation is X̂ = H(X) + w, w ~ N(0, W⁻¹), where H stacks R_bᵀ(t_t - t_b) and, for a pose, the relative rotation
// R_bᵀ R_t (paper's (10), (11)). Its residual is r = X̂ - H(X): translation in the frame of the base; rotation
// Log((R_bᵀ R_t)ᵀ R̂), in 2D the heading difference wrapped to [-π, π].

#include <algorithm>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/loss.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {

/// A relative pose: odometry, closure or, from the World, a prior of a pose. Coordinates that were not measured (the rotation
/// of a GPS position, say) have zero rows and columns in `information`. Only priors have levers.
template <int Dim>
struct PoseFactor {
  PoseIndex base = kWorld;
  PoseIndex target = 0;
  Pose<Dim> measured;           ///< Target in the frame of the base.
  PoseMatrix<Dim> information;  ///< W, symmetric positive semidefinite (1/m², 1/(m rad), 1/rad²).
  Loss loss = {};
  Point<Dim> lever = Point<Dim>::Zero();  ///< The measured point on the target, in its frame: an antenna, say (m).

  bool operator==(const PoseFactor&) const = default;
};

/// The position of a feature in the frame of the pose that saw it or, from the World, a prior of a feature.
template <int Dim>
struct FeatureFactor {
  PoseIndex base = kWorld;
  FeatureIndex target = 0;
  Point<Dim> measured;           ///< Feature in the frame of the base (m).
  PointMatrix<Dim> information;  ///< W, symmetric positive semidefinite (1/m²).
  Loss loss = {};

  bool operator==(const FeatureFactor&) const = default;
};

/// The later pose of a factor in driving order.
template <int Dim>
PoseIndex later_pose(const PoseFactor<Dim>& factor) {
  return std::max(factor.base, factor.target);
}

/// The number of repeated edges: those beyond the first between the same two poses, whatever their direction.
template <int Dim>
std::int64_t count_repeated(std::span<const PoseFactor<Dim>> edges) {
  std::vector<std::pair<PoseIndex, PoseIndex>> ends;
  ends.reserve(edges.size());
  for (const auto& edge : edges) ends.emplace_back(std::minmax(edge.base, edge.target));
  std::sort(ends.begin(), ends.end());
  return ends.end() - std::unique(ends.begin(), ends.end());
}

/// The part of its target that a factor measures: the end of its lever with the target's rotation, or the whole feature.
template <int Dim>
Pose<Dim> measured_part(const PoseFactor<Dim>& factor, const Pose<Dim>& target) {
  return factor.lever.isZero(0.0) ? target : Pose<Dim>{transform(target, factor.lever), target.rotation};
}
template <int Dim>
const Point<Dim>& measured_part(const FeatureFactor<Dim>&, const Point<Dim>& target) {
  return target;
}

/// True if a factor measures its target's position (rotation): all these diagonal entries of its information are positive.
template <int Dim>
bool measures_position(const PoseFactor<Dim>& factor) {
  return (factor.information.diagonal().template head<Dim>().array() > 0.0).all();
}
template <int Dim>
bool measures_position(const FeatureFactor<Dim>& factor) {
  return (factor.information.diagonal().array() > 0.0).all();
}
template <int Dim>
bool measures_rotation(const PoseFactor<Dim>& factor) {
  return (factor.information.diagonal().template tail<kRotationDof<Dim>>().array() > 0.0).all();
}

/// The prior without its lever: cost, gradient and Gauss-Newton H are the same if the target has this value, and agree to first
/// order elsewhere.
template <int Dim>
PoseFactor<Dim> without_lever(PoseFactor<Dim> prior, const Pose<Dim>& target) {
  constexpr int kRot = kRotationDof<Dim>;
  PointPoseMatrix<Dim> J_end_target;
  const Point<Dim> lever = transform(target, prior.lever, &J_end_target) - target.translation;
  const auto J_end_rotation = J_end_target.template rightCols<kRot>();
  const auto is_measured = prior.information.diagonal().template tail<kRot>().array() > 0.0;
  // A rotation residual r has the Jacobian Jr⁻¹(-r). Without the lever r is such that the measured rows of J_lever r are those
  // of the residual with it, and the others zero.
  const RotationVector<Dim> r_lever = (target.rotation.inverse() * prior.measured.rotation).log();
  const RotationVector<Dim> r_measured = is_measured.select(r_lever.array(), 0.0);
  const RotationJacobian<Dim> J_lever = right_jacobian_inverse(RotationVector<Dim>(-r_lever));
  const RotationVector<Dim> r = J_lever.inverse() * r_measured;
  const RotationJacobian<Dim> J_inverse = right_jacobian_inverse(RotationVector<Dim>(-r)).inverse();
  PoseMatrix<Dim> J = PoseMatrix<Dim>::Identity();  // of the residual with the lever by that without it
  J.template topRightCorner<Dim, kRot>() = J_end_rotation * J_inverse;
  J.template bottomRightCorner<kRot, kRot>() = J_lever * J_inverse;
  prior.measured.translation -= lever + J_end_rotation * r;
  prior.measured.rotation = target.rotation * Rotation<Dim>::exp(r);
  const PoseMatrix<Dim> W = J.transpose() * prior.information * J;
  prior.information = 0.5 * (W + W.transpose());
  prior.lever.setZero();
  return prior;
}

/// The fault of a factor, "has … that …"; nullopt if its measurement, lever and loss are valid and its information matrix
/// passes `check`, which may make it symmetric.
template <typename Factor>
std::optional<std::string> fault(Factor& factor, InformationCheck& check) {
  if (!is_valid(factor.measured)) return "has a measurement that is not finite, or no rotation";
  if constexpr (requires { factor.lever; }) {
    if (!is_valid(factor.lever)) return "has a lever that is not finite";
    if (factor.base != kWorld && !factor.lever.isZero(0.0)) return "has a lever, which only priors have";
  }
  if (!is_valid(factor.loss))
    return "has a loss whose ends are not 0 < quadratic_to <= constant_from, or have no finite product above 0";
  const auto of_information = check.fault(factor.information);
  return of_information ? std::optional("has an information matrix that " + *of_information) : std::nullopt;
}

}  // namespace mapjoin
