// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin {
namespace {

/// The heading residual φ̂ - (φ_t - φ_b), not wrapped.
double plain_residual(const Pose<2>& measured, const Pose<2>& base, const Pose<2>& target) {
  return measured.rotation.angle() - (target.rotation.angle() - base.rotation.angle());
}

/// The turns that wrap the heading residual (rad); 0 in space.
double turns(const Pose<2>& measured, const Pose<2>& base, const Pose<2>& target) {
  const double plain = plain_residual(measured, base, target);
  return wrap_angle(plain) - plain;
}
double turns(const Pose<3>&, const Pose<3>&, const Pose<3>&) {
  return 0.0;
}

}  // namespace

template <int Dim>
UnwrappedObjective<Dim>::UnwrappedObjective(const JoiningSystem<Dim>& system, const Values<Dim>& reference) : system_(system) {
  for_each_integrated(system, [&](const IntegratedObservation<Dim>& o) {
    for (std::size_t p = 0; p < o.poses.size(); ++p) {
      turns_.push_back(turns(o.measured_poses[p], reference.pose(o.base), reference.pose(o.poses[p])));
    }
  });
}

template <int Dim>
double UnwrappedObjective<Dim>::operator()(const Values<Dim>& state) const {
  double chi2 = 0.0;
  auto turned = turns_.begin();
  Eigen::VectorXd r;
  for_each_integrated(system_, [&](const IntegratedObservation<Dim>& o) {
    const Pose<Dim> base = state.pose(o.base);
    r.resize(o.W.rows());
    Eigen::Index row = 0;
    for (std::size_t p = 0; p < o.poses.size(); ++p, row += kPoseDof<Dim>, ++turned) {
      const Pose<Dim> target = state.pose(o.poses[p]);
      r.segment<kPoseDof<Dim>>(row) = residual<Dim>(o.measured_poses[p], base, target);
      if constexpr (Dim == 2) r[row + 2] = plain_residual(o.measured_poses[p], base, target) + *turned;
    }
    for (std::size_t f = 0; f < o.features.size(); ++f, row += Dim) {
      r.segment<Dim>(row) = residual<Dim>(o.measured_features[f], base, state.features[o.features[f]]);
    }
    chi2 += r.dot(o.W * r);
  });
  return chi2;
}

template class UnwrappedObjective<2>;
template class UnwrappedObjective<3>;

}  // namespace mapjoin
