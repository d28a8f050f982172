// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/marginals.hpp>

namespace mapjoin {

template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, double far, const std::stop_token& stop) {
  std::vector<UncertainPose<Dim>> mismatches(closures.size());
  if (closures.empty()) return mismatches;
  const CrossCovariances cross(system.equations());
  const auto covariance = [&](PoseIndex pose) -> PoseMatrix<Dim> {
    const Variable v = system.variable(pose);
    return v == kConstant ? PoseMatrix<Dim>::Zero() : PoseMatrix<Dim>(marginals[v]);
  };
  parallel_for(closures.size(), [&](std::size_t k) {
    if (stop.stop_requested()) return;
    const PoseFactor<Dim>& closure = closures[k];
    const auto& poses = system.estimate().poses;
    const auto [r, J_target, J_base] = linearise<Dim>(closure.measured, poses[closure.base], poses[closure.target]);
    const PoseMatrix<Dim> own = covariance_of(closure.information);
    const PoseMatrix<Dim> of_ends =
        J_base * covariance(closure.base) * J_base.transpose() + J_target * covariance(closure.target) * J_target.transpose();
    const PoseMatrix<Dim> most = own + 2.0 * of_ends;  // however the ends are correlated
    mismatches[k] = {retract(Pose<Dim>{}, r), most};
    if (r.dot(most.llt().solve(r)) > far) return;
    const Variable u = system.variable(closure.base);
    const Variable v = system.variable(closure.target);
    PoseMatrix<Dim> across = PoseMatrix<Dim>::Zero();
    if (u != kConstant && v != kConstant) across = J_base * cross.between(u, v) * J_target.transpose();
    mismatches[k].covariance = own + of_ends + across + across.transpose();
  });
  return mismatches;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                   \
  template std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>&, const Marginals&, \
                                                      std::span<const PoseFactor<Dim>>, double, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
