// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/cross_covariances.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The closures (by place) from one base, and their targets.
struct OfBase {
  std::vector<std::size_t> closures;
  std::vector<Variable> targets;
};

/// The longest side of the box around all poses (m), at least 1.
template <int Dim>
double extent_of(const Values<Dim>& values) {
  Eigen::AlignedBox<double, Dim> box;
  for (const Pose<Dim>& pose : values.poses) box.extend(pose.translation);
  return std::max(1.0, box.sizes().maxCoeff());
}

}  // namespace

template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, double far, const std::stop_token& stop) {
  std::vector<UncertainPose<Dim>> mismatches(closures.size());
  const auto linearised = [&](const PoseFactor<Dim>& closure) {
    const auto& poses = system.estimate().poses;
    return linearise<Dim>(closure.measured, poses[closure.base], poses[closure.target]);
  };
  const auto covariance = [&](PoseIndex pose) -> PoseMatrix<Dim> {
    const Variable v = system.variable(pose);
    return v == kConstant ? PoseMatrix<Dim>::Zero() : PoseMatrix<Dim>(marginals[v]);
  };
  const double extent = extent_of(system.estimate());
  std::vector<char> are_near(closures.size());
  parallel_for(closures.size(), [&](std::size_t k) {
    if (stop.stop_requested()) return;
    const auto [r, J_target, J_base] = linearised(closures[k]);
    const PoseMatrix<Dim> own = covariance_of(completed(closures[k], extent).information);
    const PoseMatrix<Dim> of_ends = J_base * covariance(closures[k].base) * J_base.transpose() +
                                    J_target * covariance(closures[k].target) * J_target.transpose();
    const PoseMatrix<Dim> most = own + 2.0 * of_ends;  // however the ends are correlated
    are_near[k] = r.dot(most.llt().solve(r)) > far ? 0 : 1;
    mismatches[k] = {retract(Pose<Dim>{}, r), are_near[k] ? PoseMatrix<Dim>(own + of_ends) : most};
  });

  std::map<Variable, OfBase> by_base;  // near closures whose ends may be correlated
  for (std::size_t k = 0; k < closures.size(); ++k) {
    const Variable base = system.variable(closures[k].base);
    const Variable target = system.variable(closures[k].target);
    if (!are_near[k] || base == kConstant || target == kConstant) continue;
    by_base[base].closures.push_back(k);
    by_base[base].targets.push_back(target);
  }
  const std::vector<std::pair<Variable, OfBase>> groups(by_base.begin(), by_base.end());
  if (groups.empty()) return mismatches;
  const CrossCovariances cross(system.equations());
  parallel_for(groups.size(), [&](std::size_t g) {
    if (stop.stop_requested()) return;
    const auto& [base, group] = groups[g];
    const Eigen::MatrixXd covariances = cross.between({&base, 1}, group.targets);
    for (std::size_t c = 0; c < group.closures.size(); ++c) {
      const std::size_t k = group.closures[c];
      const auto [r, J_target, J_base] = linearised(closures[k]);
      const PoseMatrix<Dim> block = covariances.middleCols<kPoseDof<Dim>>(static_cast<Eigen::Index>(c) * kPoseDof<Dim>);
      const PoseMatrix<Dim> across = J_base * block * J_target.transpose();
      mismatches[k].covariance += across + across.transpose();
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
