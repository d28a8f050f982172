// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files of a folder of the UTIAS multi-robot data (MRCLAM): odometry and sightings of the robots, as recorded.

#include <cstdint>
#include <filesystem>
#include <map>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace mapjoin::mrclam {

/// The velocity that a robot reports.
struct Velocity {
  double time = 0.0;     ///< (s), the start of its validity.
  double forward = 0.0;  ///< (m/s)
  double turn = 0.0;     ///< (rad/s)
};

/// A barcode that a robot saw.
struct BarcodeSighting {
  double time = 0.0;  ///< (s)
  std::uint64_t barcode = 0;
  double range = 0.0;    ///< (m)
  double bearing = 0.0;  ///< (rad), from ahead to the left.
};

/// The first landmark; subjects below are robots.
constexpr std::uint64_t kFirstLandmark = 6;
constexpr bool is_landmark(std::uint64_t subject) {
  return subject >= kFirstLandmark;
}

/// The odometry, never empty, and the sightings of one robot, both in the order of time.
struct Robot {
  std::vector<Velocity> odometry;
  std::vector<BarcodeSighting> sightings;

  /// True from the time of the first odometry on.
  bool has_odometry_at(double time) const { return time >= odometry.front().time; }
};

/// The robots of a folder.
struct Team {
  std::map<std::uint64_t, Robot> robots;            ///< Robots by subject.
  std::map<std::uint64_t, std::uint64_t> subjects;  ///< Subjects by barcode.

  /// The landmark or the other robot that a robot saw; nullopt if the barcode is unknown, its own, or that of a robot not in
  /// the folder, or if one of the two robots has no odometry then.
  std::optional<std::uint64_t> subject_of(const BarcodeSighting& seen, std::uint64_t robot) const;
  /// The kind of a sighting without subject_of(), for SkipCounts; empty if its barcode is unknown or its own.
  std::string_view kind_left_out(const BarcodeSighting& seen, std::uint64_t robot) const;
};

/// Reads `Barcodes.dat` and, of each robot that has odometry, `RobotN_Odometry.dat` and `RobotN_Measurement.dat`, both of which
/// may be packed (.gz). Bad input names the file and the line.
Expected<Team> read_team(const std::filesystem::path& folder);

}  // namespace mapjoin::mrclam
