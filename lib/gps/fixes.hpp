// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Fixes of a satellite receiver, and their conversion to priors of the poses of a log.

#include <cstdint>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// A position of the antenna at a time, or at a pose.
struct GpsFix {
  std::size_t line = 0;                            ///< Line of its file, from 1.
  std::variant<std::int64_t, std::uint64_t> when;  ///< Time (ns), or key of the pose.
  std::optional<std::uint32_t> session;            ///< Session of the antenna; nullopt if not given.
  GeographicPoint place;
  Vector<3> deviation = Vector<3>::Zero();  ///< Standard deviations east, north, up (m).
};

/// The valid range of a number of a fix or a lever.
struct GpsRange {
  double least;
  double most;
  bool contains(double value) const { return value >= least && value <= most; }
};
inline constexpr GpsRange kLatitudes{-90.0, 90.0};     ///< (°)
inline constexpr GpsRange kLongitudes{-360.0, 360.0};  ///< (°)
inline constexpr GpsRange kHeights{-1e7, 1e7};         ///< (m)
inline constexpr GpsRange kDeviations{1e-6, 1e6};      ///< (m)
inline constexpr GpsRange kLevers{-1e4, 1e4};          ///< (m)

struct GpsFixes {
  std::string source;        ///< The file, for messages.
  bool has_heights = false;  ///< True if fixes have heights; without them they are of use in the plane only.
  std::vector<GpsFix> fixes;
};

struct GpsOptions {
  Point<3> lever = Point<3>::Zero();  ///< The antenna in the frame of a pose (m).
  double most_apart = 1.0;            ///< The longest time between a fix and the pose nearest to it in time (s).

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// The result of attaching fixes, which are the last pose priors of the log.
struct AttachedFixes {
  GeographicFrame frame;           ///< Frame of the map; its origin is the median of all fixes.
  std::vector<std::size_t> lines;  ///< Line in the file of each prior.
  std::int64_t left_out = 0;       ///< Fixes without a pose near them.
};

/// Adds a prior with a lever for every fix. A fix between two poses goes to the nearer one in time; its lever ends where the
/// antenna was if the robot moved at constant speed along the odometry between them. A fix is left out if odometry does not tie
/// the two poses, if the nearer one is more than `most_apart` away, or if it is before the first or after the last pose. Fixed
/// poses of the log are released, and counted as skipped: the fixes hold the map. kUsage: a log with priors, which are in
/// another frame; fixes by time if poses have no stamps; fixes without heights in space. kBadInput: a fault that
/// check_invariants() finds in the log; no fix is near a pose; a fix that several sessions could have made; a place or standard
/// deviations beyond these ranges. Throws std::invalid_argument if options do not validate.
template <int Dim>
Expected<AttachedFixes> attach_fixes(const GpsFixes& fixes, const GpsOptions& options, Log<Dim>& log);

}  // namespace mapjoin
