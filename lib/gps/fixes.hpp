// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Fixes of a satellite receiver beside a log, and how they become priors of its poses.

#include <cstdint>
#include <mapjoin/gps/geographic_frame.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin {

/// Where the antenna was at a time, or at a pose.
struct GpsFix {
  std::size_t line = 0;                            ///< Of its file, from 1.
  std::variant<std::int64_t, std::uint64_t> when;  ///< Its time (ns), or the key of the pose.
  std::optional<std::uint32_t> session;            ///< Whose antenna it was, where that is said.
  GeographicPoint place;
  Vector<3> deviation = Vector<3>::Zero();  ///< Standard deviations east, north, up (m).
};

/// What the numbers of a fix and of a lever may be.
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
  bool has_heights = false;  ///< Without them they are of use in the plane only.
  std::vector<GpsFix> fixes;
};

struct GpsOptions {
  Point<3> lever = Point<3>::Zero();  ///< The antenna in the frame of a pose (m).
  double most_apart = 1.0;            ///< A fix and the pose nearest to it in time may be (s).

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// What became of the fixes: the last pose priors of the log.
struct AttachedFixes {
  GeographicFrame frame;           ///< Of the map; its origin is the median of all fixes.
  std::vector<std::size_t> lines;  ///< Of the file, by prior.
  std::int64_t left_out = 0;       ///< Fixes that no pose is near.
};

/// Adds a prior with a lever for every fix. A fix between two poses is of the nearer one in time, its lever that of the antenna
/// as it stood when odometry led at a constant speed from the one to the other; where no odometry leads there it is left out,
/// as is a fix before the first pose and behind the last one. Whatever the log fixes is released, and counted as skipped: the
/// fixes hold the map. kUsage: a log with priors, which are in another frame; fixes by time where poses have none; fixes
/// without heights in space. Bad input: no fix is near a pose; a fix at a time that several sessions have; one whose place or
/// standard deviations are beyond these ranges. Options that do not validate are std::invalid_argument.
template <int Dim>
Expected<AttachedFixes> attach_fixes(const GpsFixes& fixes, const GpsOptions& options, Log<Dim>& log);

}  // namespace mapjoin
