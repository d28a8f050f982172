// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <map>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <utility>

namespace mapjoin {

namespace {

/// The places of closures, by the pose that they begin at.
template <int Dim>
std::vector<std::vector<std::size_t>> by_base(std::span<const PoseFactor<Dim>> closures) {
  std::map<PoseIndex, std::vector<std::size_t>> places;
  for (std::size_t k = 0; k < closures.size(); ++k) places[closures[k].base].push_back(k);
  std::vector<std::vector<std::size_t>> groups;
  for (auto& [base, group] : places) groups.push_back(std::move(group));
  return groups;
}

}  // namespace

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
  struct Near {
    PoseMatrix<Dim>& covariance;  // so far, as if the ends were not correlated
    PoseMatrix<Dim> J_base;
    PoseMatrix<Dim> J_target;
  };
  const auto groups = by_base(closures);
  parallel_for(groups.size(), [&](std::size_t group) {
    if (stop.stop_requested()) return;
    const PoseIndex base = closures[groups[group].front()].base;
    const PoseMatrix<Dim> of_base = covariance(base);
    std::vector<Near> near;
    std::vector<Variable> targets;
    for (const std::size_t k : groups[group]) {
      const PoseFactor<Dim>& closure = closures[k];
      const auto& poses = system.estimate().poses;
      const auto [r, J_target, J_base] = linearise<Dim>(closure.measured, poses[base], poses[closure.target]);
      const PoseMatrix<Dim> own = covariance_of(closure.information);
      const PoseMatrix<Dim> of_ends =
          J_base * of_base * J_base.transpose() + J_target * covariance(closure.target) * J_target.transpose();
      const PoseMatrix<Dim> most = own + 2.0 * of_ends;  // however the ends are correlated
      mismatches[k] = {retract(Pose<Dim>{}, r), most};
      if (r.dot(most.llt().solve(r)) > far) continue;
      mismatches[k].covariance = own + of_ends;
      const Variable target = system.variable(closure.target);
      if (system.variable(base) == kConstant || target == kConstant) continue;
      near.push_back({mismatches[k].covariance, J_base, J_target});
      targets.push_back(target);
    }
    if (targets.empty()) return;
    const auto blocks = cross.between(system.variable(base), targets);
    for (std::size_t k = 0; k < near.size(); ++k) {
      const PoseMatrix<Dim> across = near[k].J_base * blocks[k] * near[k].J_target.transpose();
      near[k].covariance += across + across.transpose();
    }
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
