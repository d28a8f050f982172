// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The segments that updates have brought so far, and the ones that may follow.

#include <map>
#include <mapjoin/join/incremental/submap_update.hpp>

namespace mapjoin {

template <int Dim>
class DrivenSegments {
 public:
  /// Adds the segment of an update, if it has one. Bad input, and nothing is added, if check_update() finds a fault; if the
  /// segment begins neither with a new pose nor with the last one of a segment that no other continues; if another pose of it
  /// is in a segment already; if a pose outside of it is in none; or if it fixes a pose that an earlier update fixes at another
  /// place.
  Expected<void> add(const SubmapUpdate<Dim>& update);
  /// Adds the new poses of `map`, an update of a local map alone, to the segment of `update`, which was added with another one.
  /// Bad input, and nothing is added, unless `map` has all poses and features of that one, the same first and last pose, and
  /// new poses that are in no segment.
  Expected<void> keep_more(const SubmapUpdate<Dim>& update, const SubmapUpdate<Dim>& map);
  /// Bad input if add() would find it; adds nothing.
  Expected<void> check(const SubmapUpdate<Dim>& update) const;

 private:
  std::map<PoseId, bool> poses_;  // true if another segment may go on from the pose
  std::map<PoseId, Pose<Dim>> fixed_;
};

}  // namespace mapjoin
