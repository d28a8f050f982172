// SPDX-License-Identifier: BSD-3-Clause
// A user's program against the installed package: a square of odometry with one closure, joined.
#include <cmath>
#include <cstdio>
#include <mapjoin/mapjoin.hpp>
#include <numbers>

int main() {
  const mapjoin::Pose<2> side{{1.0, 0.0}, mapjoin::Rotation<2>(std::numbers::pi / 2.0)};
  mapjoin::LogBuilder<2> builder("square");
  for (std::uint64_t k = 0; k < 4; ++k) builder.add_pose_edge({0, k}, {0, k + 1}, side, mapjoin::PoseMatrix<2>::Identity());
  builder.add_pose_edge({0, 0}, {0, 4}, {}, mapjoin::PoseMatrix<2>::Identity());
  const auto log = std::move(builder).finish();
  if (!log) return 1;

  const auto result = mapjoin::run(*log, mapjoin::RunOptions{});
  if (!result) return 1;
  std::printf("mapjoin %s: chi2 %.3g over %d degrees of freedom\n", mapjoin::kVersion.data(), result->chi2,
              static_cast<int>(result->dof));
  return result->chi2 < 1e-12 && result->dof == 3 ? 0 : 1;
}
