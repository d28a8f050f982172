// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The features that segments see; segments come one after the other, and their begins differ.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/ids.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

class SeenFeatures {
 public:
  explicit SeenFeatures(std::size_t features) : seen_in_(features, kWorld) {}

  /// Notes that the segment beginning at `begin` sees a feature; true for the first time.
  bool see(FeatureIndex feature, PoseIndex begin) { return std::exchange(seen_in_[feature], begin) != begin; }
  /// The number of features that the segment sees for the first time by these observations.
  template <typename Observations>
  std::int64_t count_new(const Observations& observations, PoseIndex begin) {
    return std::count_if(observations.begin(), observations.end(), [&](const auto& o) { return see(o.target, begin); });
  }

 private:
  Table<FeatureIndex, PoseIndex> seen_in_;  // begin of the segment that saw each feature last
};

}  // namespace mapjoin
