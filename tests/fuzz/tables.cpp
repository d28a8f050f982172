// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/gps_csv.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/fuzz/promises.hpp>
#include <tests/fuzz/targets.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::fuzz {
namespace {

/// A log of poses 0 to 4 in a row, a second apart.
Log<2> five_poses() {
  LogBuilder<2> builder("log");
  for (std::uint64_t k = 0; k < 5; ++k) {
    builder.add_stamp({0, k}, static_cast<std::int64_t>(1'000'000'000 * k));
    if (k > 0) builder.add_pose_edge({0, k - 1}, {0, k}, {Point<2>(1.0, 0.0), Rotation<2>(0.1)}, PoseMatrix<2>::Identity());
  }
  builder.fix({0, 0});
  return std::move(builder).finish().value();
}

}  // namespace

void pose_csv(std::string_view bytes) {
  const auto log = read_pose_csv(bytes, "poses.csv", {});
  check(log, "poses.csv");
  if (!log) return;
  promise(is_pose_csv(bytes), "what is read is recognised");
  check_round_trip(*log, LogFormat::kCsv);
}

void stamps(std::string_view bytes) {
  static const testing::TemporaryFolder folder;
  const auto path = folder.file("stamps.txt", bytes);
  Log<2> log = five_poses();
  const auto read = read_stamps(path, log);
  if (!read) return check_error(read.error(), path);
  promise(log.stamps_ns.size() == log.poses.size(), "every pose has a time");
}

/// Reads fixes, and attaches them to a log.
void gps_csv(std::string_view bytes) {
  const auto fixes = read_gps_csv(bytes, "fixes.csv");
  if (!fixes) return check_error(fixes.error(), "fixes.csv");
  promise(!fixes->fixes.empty(), "there are fixes");
  for (const GpsFix& fix : fixes->fixes) {
    const auto& [latitude, longitude, height] = fix.place;
    promise(std::abs(latitude) <= 90.0 && std::abs(longitude) <= 360.0 && std::isfinite(height), "places are on the earth");
    promise(fix.deviation.head<2>().minCoeff() > 0.0, "standard deviations are positive");
  }
  Log<2> log = five_poses();
  const auto attached = attach_fixes(*fixes, {}, log);
  if (!attached) return check_error(attached.error(), "fixes.csv");
  promise(log.pose_priors().size() == attached->lines.size(), "every fix that is not left out is a prior");
  promise(attached->lines.size() + static_cast<std::size_t>(attached->left_out) == fixes->fixes.size(), "none is lost");
  check_log(log);
}

}  // namespace mapjoin::fuzz
