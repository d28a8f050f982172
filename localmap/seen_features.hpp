// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The features that stretches see, one stretch after the other.

#include <mapjoin/model/ids.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

class SeenFeatures {
 public:
  explicit SeenFeatures(std::size_t features) : seen_in_(features, -1) {}

  /// Whether the stretch that begins at `begin` sees a feature for the first time; it has seen it now.
  bool is_new(Index feature, Index begin) { return std::exchange(seen_in_[static_cast<std::size_t>(feature)], begin) != begin; }

 private:
  std::vector<Index> seen_in_;  // per feature: the stretch, by its begin, that saw it last
};

}  // namespace mapjoin
