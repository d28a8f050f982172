// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The probability of seeing a feature by its distance, learnt from which maps see the features of others.

#include <cstddef>
#include <utility>
#include <vector>

namespace mapjoin {

/// The chance that a map sees a feature, by the distance of the feature from the nearest of the map's poses.
class SightingChance {
 public:
  /// Each trial is a distance (m), and true if the feature was seen.
  explicit SightingChance(std::vector<std::pair<double, bool>> trials);

  /// The probability at a distance (m); 0 beyond all trials.
  double operator()(double distance) const;

 private:
  struct Ring {
    double end;  // (m)
    double chance;
  };
  std::vector<Ring> rings_;  // ascending, with equally many trials in each
};

}  // namespace mapjoin
