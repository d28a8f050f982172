// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The cut of a log into segments, and the poses that stay in the joined state.

#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/segment.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// The rule for the length of a segment.
enum class SplitRule : std::uint8_t {
  kAuto,      ///< A number of steps, at least `amount` or 100, if that is less, chosen by a cost model (docs/decisions.md).
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

/// Segments of a log and the poses that stay. Consecutive segments of a session share their end/start pose, so that every step
/// of odometry belongs to one segment; an observation belongs to the segment that starts at or contains its pose or, from the
/// last pose of a session, to its last segment.
struct Split {
  std::vector<Segment> segments;
  /// The poses that stay in the joined state: ends of segments and of closures, poses with priors, fixed ones, those that
  /// split() was told of, and every pose of a raw segment.
  Table<PoseIndex, bool> kept;
  /// The chosen steps per map; 0 if the rule does not count poses.
  int poses_per_map = 0;
};

/// Makes one of the segments raw, so that all its poses stay.
void make_raw(Segment& segment, Split& split);

/// The segments of a split for one share: consecutive local maps, as many as in the other shares but for one; the other
/// segments are raw.
std::vector<Segment> segments_of(const Share& share, const Split& split);

/// Cuts a log into segments. A segment stays raw if it would keep most of its inner poses, or if its border is too large. Poses
/// marked in `elsewhere`, which others refer to, stay too; empty: none, otherwise as long as the poses. Throws
/// std::invalid_argument if the options do not validate, for another length, and if check_invariants() finds a fault in the
/// log. O(size of the log).
template <int Dim>
Split split(const Log<Dim>& log, const SplitOptions& options, const Table<PoseIndex, bool>& elsewhere = {});

/// The split with these segments, which was made before, as a store keeps it. Throws std::invalid_argument if a segment has
/// poses that are not in the log, std::out_of_range if a factor has.
template <int Dim>
Split split_along(const Log<Dim>& log, std::vector<Segment> segments);

/// Checks that a split is one of this log, or of the first part of it. kBadInput if check_invariants() finds a fault in the
/// log, and unless every session has its segments in turn, each beginning where the one before ends, up to some pose; and
/// `kept` is as long as the poses and keeps all that split_along() keeps.
template <int Dim>
Expected<void> check_split(const Log<Dim>& log, const Split& split);

/// The cost of a map of N steps per step of the log, in units of one sparse floating-point operation, from a sample of the log:
///   ( 4 (30 m² + 0.4 m³) + 5 (2 N dof m² + 0.5 m³) ) / N,
/// where m is the size of a map's border (kept poses and features). The first term is assembling and factorising the map in the
/// join, four times; the others are eliminating its interior and factorising its border, five times while it is built,
/// recovered and polished. `kept` marks the poses that the rest of the log mentions; they are in the border, too. A segment
/// that would stay raw costs as much as its one-step maps in the join.
template <int Dim>
double cost_per_step(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, int poses_per_map);

/// The least number of steps, among 1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100 and at least `fewest`, with a cost within a
/// hundredth of the cheapest; 100 if there is none.
template <int Dim>
int cheapest_poses_per_map(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, double fewest);

}  // namespace mapjoin
