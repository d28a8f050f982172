// SPDX-License-Identifier: BSD-3-Clause
// build_a_log: measurements that are in memory already, a square of one metre with a feature in its middle.
#include <iostream>
#include <mapjoin/mapjoin.hpp>
#include <numbers>

int main() {
  using namespace mapjoin;
  const Pose<2> side{{1.0, 0.0}, Rotation<2>(std::numbers::pi / 2.0)};
  const PoseMatrix<2> odometry = Eigen::Vector3d(100.0, 100.0, 400.0).asDiagonal();  // 1/m², 1/m², 1/rad²
  const PointMatrix<2> sight = 25.0 * PointMatrix<2>::Identity();

  LogBuilder<2> builder("square");
  for (std::uint64_t k = 0; k < 4; ++k) {
    const PoseId here{0, k};  // Session 0, pose k; features count apart.
    builder.add_pose_edge(here, {0, k + 1}, side, odometry);
    builder.add_observation(here, FeatureId{0}, {0.5, 0.5}, sight);
  }
  const auto log = std::move(builder).finish();
  if (!log) return 1;

  const auto result = solve(*log, RunOptions{});
  if (!result) return 1;
  const Point<2>& middle = result->map.features.front();
  std::cout << to_string(log->features.front()) << " is at " << middle.x() << ", " << middle.y() << '\n';
}
