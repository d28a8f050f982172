// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The segments that updates have brought so far, and which ones may follow.

#include <map>
#include <mapjoin/join/incremental/submap_update.hpp>

namespace mapjoin {

class DrivenSegments {
 public:
  /// Adds the segment of an update, if it has one. Bad input where check_update() finds a fault, where the segment does not
  /// begin with a new pose or with the last one of a segment that none goes on from yet, or where its other poses are not new
  /// and all else that the update concerns is not known: nothing is added.
  template <int Dim>
  Expected<void> add(const SubmapUpdate<Dim>& update);

 private:
  template <int Dim>
  Expected<void> check(const SubmapUpdate<Dim>& update) const;

  std::map<PoseId, bool> poses_;  // and whether another segment may go on from there
};

}  // namespace mapjoin
