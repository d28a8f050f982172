// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The features that segments see; segments come one after the other, and their begins differ.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/ids.hpp>
#include <utility>

namespace mapjoin {

class SeenFeatures {
 public:
  explicit SeenFeatures(std::size_t features) : seen_in_(features, kWorld) {}

  /// Notes what the segment beginning at `begin` sees by these observations; returns the number of features that it had not
  /// seen.
  template <typename Observations>
  std::int64_t count_new(const Observations& observations, PoseIndex begin) {
    return std::count_if(observations.begin(), observations.end(),
                         [&](const auto& o) { return std::exchange(seen_in_[o.target], begin) != begin; });
  }

 private:
  Table<FeatureIndex, PoseIndex> seen_in_;  // begin of the segment that saw each feature last
};

}  // namespace mapjoin
