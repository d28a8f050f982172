// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Runs of poses that are joined as one.

#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// Poses [begin, end] that are joined as one, both included: neighbours of one session share their end/start pose.
struct Segment {
  PoseIndex begin = 0;
  PoseIndex end = 0;
  bool is_map = true;  ///< A local map from its start to its end pose, else raw: its observations as they are.
  bool operator==(const Segment&) const = default;
};

/// The segments that are local maps, in their order, as the local maps stand beside them; they point into `segments`.
inline std::vector<const Segment*> map_segments(const std::vector<Segment>& segments) {
  std::vector<const Segment*> maps;
  for (const Segment& segment : segments) {
    if (segment.is_map) maps.push_back(&segment);
  }
  return maps;
}

}  // namespace mapjoin
