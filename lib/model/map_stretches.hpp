// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The stretches that are local maps.

#include <mapjoin/model/local_map.hpp>
#include <vector>

namespace mapjoin {

/// In their order, as the local maps stand beside them; they point into `stretches`.
inline std::vector<const Stretch*> map_stretches(const std::vector<Stretch>& stretches) {
  std::vector<const Stretch*> maps;
  for (const Stretch& stretch : stretches) {
    if (stretch.is_map) maps.push_back(&stretch);
  }
  return maps;
}

}  // namespace mapjoin
