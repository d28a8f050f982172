// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Runs of poses that are joined as one.

#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// Poses [begin, end] that are joined as one, both included: neighbours of one session share their end/start pose.
struct Stretch {
  Index begin = 0;
  Index end = 0;
  bool is_map = true;  ///< A local map from its start to its end pose, else a span of its observations as they are.
  bool operator==(const Stretch&) const = default;
};

/// The stretches that are local maps, in their order, as the local maps stand beside them; they point into `stretches`.
inline std::vector<const Stretch*> map_stretches(const std::vector<Stretch>& stretches) {
  std::vector<const Stretch*> maps;
  for (const Stretch& stretch : stretches) {
    if (stretch.is_map) maps.push_back(&stretch);
  }
  return maps;
}

}  // namespace mapjoin
