// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin {
namespace {

/// φ̂ - (φ_t - φ_b).
double plain_residual(const Pose<2>& measured, const Pose<2>& base, const Pose<2>& target) {
  return measured.rotation.angle() - (target.rotation.angle() - base.rotation.angle());
}

/// What wraps it.
double turns(const Pose<2>& measured, const Pose<2>& base, const Pose<2>& target) {
  const double plain = plain_residual(measured, base, target);
  return wrap_angle(plain) - plain;
}
double turns(const Pose<3>&, const Pose<3>&, const Pose<3>&) {
  return 0.0;
}

}  // namespace

template <int Dim>
UnwrappedObjective<Dim>::UnwrappedObjective(const JointSystem<Dim>& system, const State<Dim>& reference) : system_(system) {
  for (const auto& [o, base, target] : system.pose_observations()) {
    turns_.push_back(turns(o->measured, reference.pose(base), reference.pose(target)));
  }
  for (const auto& placed : system.maps()) {
    for (std::size_t p = 0; p < placed.poses.size(); ++p) {
      turns_.push_back(turns(placed.map->pose_estimates[p], reference.pose(placed.base), reference.pose(placed.poses[p])));
    }
  }
}

template <int Dim>
PoseVector<Dim> UnwrappedObjective<Dim>::unwrapped(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target,
                                                   [[maybe_unused]] std::size_t pose) const {
  PoseVector<Dim> r = residual<Dim>(measured, base, target);
  if constexpr (Dim == 2) r[2] = plain_residual(measured, base, target) + turns_[pose];
  return r;
}

template <int Dim>
double UnwrappedObjective<Dim>::operator()(const State<Dim>& state) const {
  double chi2 = 0.0;
  std::size_t pose = 0;
  for (const auto& [o, base, target] : system_.pose_observations()) {
    const PoseVector<Dim> r = unwrapped(o->measured, state.pose(base), state.pose(target), pose++);
    chi2 += r.dot(o->information * r);
  }
  for (const auto& [o, base, target] : system_.feature_observations()) {
    const Point<Dim> r = residual<Dim>(o->measured, state.pose(base), state.feature(target));
    chi2 += r.dot(o->information * r);
  }
  for (const auto& placed : system_.maps()) {
    chi2 += map_chi2(placed, state, pose);
    pose += placed.poses.size();
  }
  return chi2;
}

template <int Dim>
double UnwrappedObjective<Dim>::map_chi2(const typename JointSystem<Dim>::PlacedMap& placed, const State<Dim>& state,
                                         std::size_t first_pose) const {
  const LocalMap<Dim>& map = *placed.map;
  const Pose<Dim> base = state.pose(placed.base);
  Eigen::VectorXd r(map.information.rows());
  Eigen::Index row = 0;
  for (std::size_t p = 0; p < map.poses.size(); ++p, row += kPoseDof<Dim>) {
    r.segment<kPoseDof<Dim>>(row) = unwrapped(map.pose_estimates[p], base, state.pose(placed.poses[p]), first_pose + p);
  }
  for (std::size_t f = 0; f < map.features.size(); ++f, row += Dim) {
    r.segment<Dim>(row) = residual<Dim>(map.feature_estimates[f], base, state.feature(placed.features[f]));
  }
  return r.dot(map.information * r);
}

template class UnwrappedObjective<2>;
template class UnwrappedObjective<3>;

}  // namespace mapjoin
