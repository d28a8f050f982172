// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/trajectory.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>

namespace mapjoin::fuzz {

/// Reads a trajectory of TUM's as a log and as a list of poses, or one of KITTI's.
void trajectory(std::string_view bytes) {
  const TextScanner text("poses.txt", bytes);
  const auto kitti = read_kitti_log(text, {});
  check(kitti, "poses.txt");
  if (kitti) check_round_trip(*kitti, LogFormat::kKitti);

  const auto tum = read_tum_log(text, {});
  check(tum, "poses.txt");
  if (tum) check_round_trip(*tum, LogFormat::kTum);

  if (!is_tum_line(text)) return;
  const auto poses = read_tum(text);
  if (!poses) check_error(poses.error(), "poses.txt");
  promise(poses || !tum, "a trajectory is one as a list, too");
  if (!poses) return;
  for (const auto& [time, pose] : *poses) {
    promise(std::isfinite(time) && pose.translation.allFinite(), "poses are finite");
    promise(std::abs(pose.rotation.quaternion().norm() - 1.0) < 1e-9, "quaternions are of unit length");
  }
}

}  // namespace mapjoin::fuzz
