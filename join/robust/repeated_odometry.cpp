// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/join/robust/repeated_odometry.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

template <int Dim>
std::vector<RepeatedOdometry> repeated_odometry(const Log<Dim>& log) {
  const auto odometry = log.odometry();
  std::vector<RepeatedOdometry> repeated;
  std::size_t first = 0;
  for (std::size_t k = 1; k < odometry.size(); ++k) {
    if (later_pose(odometry[k]) != later_pose(odometry[first])) {
      first = k;
      continue;
    }
    const UncertainPose<Dim> loop = compose(forwards(odometry[first]), inverse(forwards(odometry[k])));
    const PoseVector<Dim> v = local(Pose<Dim>{}, loop.mean);
    repeated.push_back({k, v.dot(loop.covariance.llt().solve(v))});
  }
  return repeated;
}

template <int Dim>
Inliers<Log<Dim>> without_contradicted_odometry(const Log<Dim>& log, double confidence) {
  Inliers<Log<Dim>> inliers{log, {}};
  const std::vector<RepeatedOdometry> repeated = repeated_odometry(log);
  const auto count = static_cast<double>(log.closures().size() + log.observations().size() + repeated.size());
  const auto& factors = log.graph.pose_factors;  // odometry comes first
  std::vector<PoseFactor<Dim>> kept;
  kept.reserve(factors.size());
  auto next = factors.begin();  // the first that is neither kept nor rejected
  for (const auto& [edge, chi2] : repeated) {
    const double probability = std::min(1.0, count * chi_squared_upper_tail(chi2, kPoseDof<Dim>));
    if (probability >= 1.0 - confidence) continue;
    const auto factor = factors.begin() + static_cast<std::ptrdiff_t>(edge);
    inliers.rejected.push_back({{PartKind::kOdometry, factor->base, factor->target, chi2, kPoseDof<Dim>, probability}});
    kept.insert(kept.end(), next, factor);
    next = factor + 1;
  }
  kept.insert(kept.end(), next, factors.end());
  inliers.input.graph.pose_factors = std::move(kept);
  return inliers;
}

#define MAPJOIN_INSTANTIATE(Dim)                                             \
  template std::vector<RepeatedOdometry> repeated_odometry(const Log<Dim>&); \
  template Inliers<Log<Dim>> without_contradicted_odometry(const Log<Dim>&, double);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
