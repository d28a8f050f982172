// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/join/robust/repeated_odometry.hpp>

namespace mapjoin {
namespace {

/// The measurement of an edge, driven forwards.
template <int Dim>
UncertainPose<Dim> forwards(const PoseFactor<Dim>& edge) {
  return edge.base < edge.target ? uncertain(edge) : inverse(uncertain(edge));
}

}  // namespace

template <int Dim>
std::vector<RepeatedOdometry> repeated_odometry(const Log<Dim>& log) {
  const auto odometry = log.odometry();
  const auto later_pose = [&](std::size_t k) { return std::max(odometry[k].base, odometry[k].target); };
  std::vector<RepeatedOdometry> repeated;
  std::size_t first = 0;
  for (std::size_t k = 1; k < odometry.size(); ++k) {
    if (later_pose(k) != later_pose(first)) {
      first = k;
      continue;
    }
    const UncertainPose<Dim> loop = compose(forwards(odometry[first]), inverse(forwards(odometry[k])));
    const PoseVector<Dim> v = local(Pose<Dim>{}, loop.mean);
    repeated.push_back({k, v.dot(loop.covariance.llt().solve(v))});
  }
  return repeated;
}

template std::vector<RepeatedOdometry> repeated_odometry(const Log<2>&);
template std::vector<RepeatedOdometry> repeated_odometry(const Log<3>&);

}  // namespace mapjoin
