// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How probably a feature is seen from so far away, learnt from which map sees the features of others.

#include <cstddef>
#include <utility>
#include <vector>

namespace mapjoin {

/// The chance that a map sees a feature, by the distance of the feature from the nearest of the map's poses.
class SightingChance {
 public:
  /// Of each trial the distance (m), and whether the feature was seen.
  explicit SightingChance(std::vector<std::pair<double, bool>> trials);

  /// Between 0 and 1; what was never tried is not seen.
  double operator()(double distance) const;

 private:
  struct Ring {
    double end;  // (m)
    double chance;
  };
  std::vector<Ring> rings_;  // ascending, as many trials in each
};

}  // namespace mapjoin
