// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files of a folder of the UTIAS multi-robot data (MRCLAM): what the robots did and saw, as it was recorded.

#include <cstdint>
#include <filesystem>
#include <map>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <vector>

namespace mapjoin::mrclam {

/// How fast a robot says it goes.
struct Velocity {
  double time = 0.0;     ///< (s) from which on it holds.
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

/// Subjects below are robots, from here on landmarks.
constexpr std::uint64_t kFirstLandmark = 6;
constexpr bool is_landmark(std::uint64_t subject) {
  return subject >= kFirstLandmark;
}

/// What the files of one robot say, in the order of time; there is odometry.
struct Robot {
  std::vector<Velocity> odometry;
  std::vector<BarcodeSighting> sightings;

  /// True from the first odometry on.
  bool has_odometry_at(double time) const { return time >= odometry.front().time; }
};

/// The robots of a folder.
struct Team {
  std::map<std::uint64_t, Robot> robots;            ///< By subject.
  std::map<std::uint64_t, std::uint64_t> subjects;  ///< By barcode.

  /// The landmark or the other robot that a robot saw; nothing where the barcode is of none, or where one of the two robots has
  /// no odometry then.
  std::optional<std::uint64_t> subject_of(const BarcodeSighting& seen, std::uint64_t robot) const;
};

/// Reads `Barcodes.dat`, and of each robot `RobotN_Odometry.dat`, where there is one, and `RobotN_Measurement.dat`, each of
/// which may be packed (.gz). Bad input names the file and the line.
Expected<Team> read_team(const std::filesystem::path& folder);

}  // namespace mapjoin::mrclam
