// SPDX-License-Identifier: BSD-3-Clause
// Five robots that see landmarks and each other, together and each alone, against motion capture.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/mrclam/mrclam.hpp>
#include <mapjoin/io/mrclam/team.hpp>
#include <mapjoin/join/robust/inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <tests/support/data.hpp>
#include <tests/support/motion_capture.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

/// The absolute trajectory error of a robot's poses in a map of it or of several robots (m).
double error_of(std::uint32_t session, const GlobalMap<2>& map, const Trajectory& truth) {
  std::vector<Pose<2>> estimated, captured;
  for (const PoseIndex p : indices(map.poses)) {
    const auto at = truth.lower_bound(1e-9 * static_cast<double>(map.stamps_ns[p]));
    if (map.pose_ids[p].session != session || at == truth.end()) continue;
    estimated.push_back(map.poses[p]);
    captured.push_back(at->second);
  }
  return absolute_trajectory_error<2>(estimated, captured).errors.translation.rms;
}

/// The map of the log in a folder without outliers, such as misread barcodes.
GlobalMap<2> map_of(const std::filesystem::path& folder) {
  const auto log = std::get<Log<2>>(read_mrclam(folder).value());
  return run(find_inliers(log, {}).value().input, without_verdict()).value().map;
}

/// The lines of a file of barcodes whose subjects are landmarks.
std::string barcodes_of_landmarks(const std::filesystem::path& file) {
  const auto bytes = FileBytes::read(file).value();
  std::string text;
  for (TextScanner lines(file.string(), bytes.view()); lines.next_line();) {
    const auto subject = lines.key();
    if (mrclam::is_landmark(subject)) text += fmt::format("{} {}\n", subject, lines.key());
  }
  return text;
}

TEST(MrclamRobots, AreTogetherNoFartherFromTheMotionCaptureThanAlone) {
  const auto data = data_file("mrclam6");
  const TemporaryFolder strangers;  // robots that do not know each other's barcodes
  for (const auto& entry : std::filesystem::directory_iterator(data)) {
    if (entry.path().filename() != "Barcodes.dat")
      std::filesystem::create_symlink(entry.path(), strangers.path() / entry.path().filename());
  }
  strangers.file("Barcodes.dat", barcodes_of_landmarks(data / "Barcodes.dat"));
  const GlobalMap<2> together = map_of(data);
  const GlobalMap<2> apart = map_of(strangers.path());
  for (std::uint32_t session = 0; session < 5; ++session) {
    const auto robot = fmt::format("Robot{}", session + 1);
    const Trajectory truth = motion_capture(data / (robot + "_Groundtruth.dat.gz"));
    const TemporaryFolder folder;
    for (const std::string& name : {std::string("Barcodes.dat"), robot + "_Odometry.dat.gz", robot + "_Measurement.dat"}) {
      std::filesystem::create_symlink(data / name, folder.path() / name);
    }
    const double with_others = error_of(session, together, truth);
    const double alone = error_of(session, map_of(folder.path()), truth);
    const double unseen = error_of(session, apart, truth);
    std::cout << robot << ": " << alone << " m alone, " << unseen << " m by shared landmarks, " << with_others
              << " m where robots see each other, too\n";
    EXPECT_LE(with_others, alone) << robot;
    EXPECT_LE(with_others, unseen) << robot;
    EXPECT_LE(with_others, 0.12) << robot;
  }
}

}  // namespace
}  // namespace mapjoin::testing
