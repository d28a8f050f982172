// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The probability of seeing a feature by its distance, learnt from which features are seen.

#include <cstddef>
#include <utility>
#include <vector>

namespace mapjoin {

/// The distance of a feature (m), and true if it was seen.
using SightingTrial = std::pair<double, bool>;

/// The chance that a feature is seen, by a distance: by a pose, by that of the feature from it; by a map, by that from the
/// nearest of its poses, or from the nearest other feature that it sees.
class SightingChance {
 public:
  SightingChance() = default;
  explicit SightingChance(std::vector<SightingTrial> trials);

  /// The probability at a distance (m); 0 beyond all trials.
  double operator()(double distance) const;
  /// The logarithm of the chance that a feature is overlooked whose distance is known to ± `error` (m): the largest of all that
  /// it may have.
  double log_overlooked(double distance, double error) const;

 private:
  struct Ring {
    double end;  // (m)
    double chance;
  };
  std::vector<Ring> rings_;  // ascending, with equally many trials in each
};

}  // namespace mapjoin
