// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The segments that updates have brought so far, and which ones may follow.

#include <map>
#include <mapjoin/join/incremental/submap_update.hpp>

namespace mapjoin {

template <int Dim>
class DrivenSegments {
 public:
  /// Adds the segment of an update, if it has one. Bad input, and nothing is added, where check_update() finds a fault; where
  /// the segment begins neither with a new pose nor with the last one of a segment that none goes on from yet; where another
  /// pose of it is in a segment already; where a pose outside of it is in none; or where it fixes a pose that an earlier update
  /// fixes at another place.
  Expected<void> add(const SubmapUpdate<Dim>& update);
  /// The same without adding it.
  Expected<void> check(const SubmapUpdate<Dim>& update) const;

 private:
  std::map<PoseId, bool> poses_;  // and whether another segment may go on from there
  std::map<PoseId, Pose<Dim>> fixed_;
};

}  // namespace mapjoin
