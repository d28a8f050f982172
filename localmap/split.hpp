// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where a log is cut into segments, and which poses the rest of the log mentions.

#include <cstdint>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/segment.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// How long a segment may grow.
enum class SplitRule : std::uint8_t {
  kAuto,      ///< By a number of steps, at least `amount`, that a cost model chooses (docs/decisions.md).
  kPoses,     ///< At most `amount` steps.
  kDistance,  ///< At least `amount` metres travelled, by odometry.
  kFeatures,  ///< At least `amount` different features seen.
};

struct SplitOptions {
  SplitRule rule = SplitRule::kAuto;
  double amount = 0.0;
  bool operator==(const SplitOptions&) const = default;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// Consecutive segments of a session share their end/start pose, so that every step of odometry belongs to one segment; an
/// observation belongs to the segment that starts at or contains its pose, those of a session's last pose to its last segment.
struct Split {
  std::vector<Segment> segments;
  /// The poses that stay in the joined state: ends of segments, what closures and the World mention, and every pose of a raw
  /// segment.
  Table<PoseIndex, bool> kept;
  /// The steps per map that were chosen; 0 where the rule does not count poses.
  int poses_per_map = 0;
};

/// Makes one of the segments a raw one, whose poses all stay.
void make_raw(Segment& segment, Split& split);

/// One of several shares of the local maps of a log, each built on its own, on another machine, say.
struct Share {
  std::size_t index = 0;  ///< From 0.
  std::size_t count = 1;
};

/// The segments of a split for whoever builds one share: consecutive local maps, as many as in the others but for one; the
/// other segments are raw.
std::vector<Segment> segments_of(const Share& share, const Split& split);

/// Cuts the log. A segment that would keep most of its inner poses stays raw of its observations. Poses that others refer to,
/// by `elsewhere`, stay too: all false where it is empty, else as long as the poses. Options that do not validate, and another
/// length, are std::invalid_argument. O(size of the log).
template <int Dim>
Split split(const Log<Dim>& log, const SplitOptions& options, const Table<PoseIndex, bool>& elsewhere = {});

/// The split that was made into these segments before, as a store keeps them.
template <int Dim>
Split split_along(const Log<Dim>& log, std::vector<Segment> segments);

/// What a map of N steps costs per step of the log, in units of one sparse floating-point operation, from a sample of the log:
///   ( 4 (30 m² + 0.4 m³) + 5 (2 N dof m² + 0.5 m³) ) / N,
/// where m is the size of a map's border (kept poses and features). The first term is assembling and factorising the map in the
/// join, four times; the others are eliminating its interior and factorising its border, five times while it is built,
/// recovered and polished. `kept` says which poses the rest of the log mentions; they are in the border, too. A segment that
/// would stay a raw segment costs what its one-step maps do, in the join only.
template <int Dim>
double cost_per_step(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, int poses_per_map);

/// The least number of steps among those of 1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100 that are at least `fewest` whose cost is
/// within a hundredth of the cheapest; 100 where there is none.
template <int Dim>
int cheapest_poses_per_map(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, double fewest);

}  // namespace mapjoin
