// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A truncated join of a world with so little noise that all is linear.

#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <tests/support/small_world.hpp>
#include <vector>

namespace mapjoin::testing {

/// Noise (m, rad) so small that everything is linear: chi2 of a log without a factor is what theory predicts.
inline constexpr double kNoise = 1e-4;
/// The threshold between squared distances of right factors, which are below 1e-4, and of wrong ones.
inline constexpr double kThreshold = 1e-3;
inline constexpr OfKinds kThresholds{kThreshold, kThreshold};

template <typename D>
class TruncatedJoinFixture : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static SmallWorld<kDim> world() {
    return small_world<kDim>({.poses = 30, .features = 10, .closures = 6, .range = 4.0, .noise = kNoise});
  }
  static TruncatedJoin<kDim> join_of(const SmallWorld<kDim>& world, const std::vector<bool>& observations = {}) {
    return TruncatedJoin<kDim>(world.log, world.truth, observations, Engine::kFronts);
  }
  static std::vector<std::size_t> closures_that_do_not_count(const TruncatedJoin<kDim>& join) {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < join.closure_tests().size(); ++k) {
      if (!join.counts(k)) out.push_back(k);
    }
    return out;
  }
  static std::ptrdiff_t observations_that_count(const TruncatedJoin<kDim>& join) {
    return std::ranges::count(join.observations_count(), true);
  }
};

}  // namespace mapjoin::testing
