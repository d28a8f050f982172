// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Segments: runs of poses, each a local map or raw; shares of them.

#include <cstddef>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// Poses begin to end, both included; neighbouring segments of a session share their end/start pose.
struct Segment {
  PoseIndex begin = 0;
  PoseIndex end = 0;
  bool is_map = true;  ///< True for a local map from start to end pose, false for a raw segment: its observations as they are.
  bool operator==(const Segment&) const = default;
};

/// One of several shares of the local maps of a log, each built on its own, on another machine, say.
struct Share {
  std::size_t index = 0;  ///< From 0.
  std::size_t count = 1;

  bool is_whole() const { return count == 1; }
  bool operator==(const Share&) const = default;
};

/// Pointers into `segments` to those that are local maps, in order, which is that of the maps themselves.
inline std::vector<const Segment*> map_segments(const std::vector<Segment>& segments) {
  std::vector<const Segment*> maps;
  for (const Segment& segment : segments) {
    if (segment.is_map) maps.push_back(&segment);
  }
  return maps;
}

}  // namespace mapjoin
