// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/corridor.hpp>

namespace mapjoin {
namespace {

using testing::bytes_in_use;
using testing::Corridor;

/// A corridor joined with a snapshot after every map, of which the last is kept. Tables grow by doubling: at twice as many maps
/// they take twice as much, wherever the doubling falls. `./dev bench soak` does this with more maps.
TEST(IncrementalSoak, MemoryGrowsInProportionToTheMapsAndIsGivenBack) {
  constexpr int kMaps = 20'000;
  const double before = bytes_in_use();
  double at_quarter = 0.0;
  double at_half = 0.0;
  double at_end = 0.0;
  {
    Corridor corridor;
    IncrementalJoin<2> joined;
    std::shared_ptr<const JoinedSnapshot<2>> snapshot;
    for (int k = 1; k <= kMaps; ++k) {
      const AddedUpdate added = joined.add(corridor.next()).value();
      ASSERT_TRUE(added.is_joined && added.converged) << k;
      snapshot = joined.snapshot();
      if (k == kMaps / 4) at_quarter = bytes_in_use() - before;
      if (k == kMaps / 2) at_half = bytes_in_use() - before;
    }
    at_end = bytes_in_use() - before;
    const auto dof = static_cast<double>(joined.dof());
    EXPECT_EQ(joined.dof(), 4 * kMaps - 7 + 3 * kMaps / 100 + 3 * kMaps / 10);
    constexpr double kScale = Corridor::kError * Corridor::kError / (Corridor::kSigma * Corridor::kSigma);
    EXPECT_NEAR(joined.chi2(), kScale * dof, kScale * 5.0 * std::sqrt(2.0 * dof));
  }
  EXPECT_NEAR(at_half, 2.0 * at_quarter, 0.1 * at_half);
  EXPECT_NEAR(at_end, 2.0 * at_half, 0.1 * at_end);
  EXPECT_LE(bytes_in_use() - before, 0.01 * at_end);
}

TEST(IncrementalSoak, IsWithinAThousandthOfTheBatchOptimumWhileMapsAreDeferred) {
  constexpr std::size_t kMaps = 3'000;
  Corridor corridor;
  std::vector<SubmapUpdate<2>> updates;
  IncrementalJoin<2> joined;
  std::size_t deferred = 0;
  double worst = 0.0;
  for (std::size_t k = 1; k <= kMaps; ++k) {
    updates.push_back(corridor.next());
    const AddedUpdate added = joined.add(updates.back()).value();
    ASSERT_TRUE(added.is_joined && added.converged) << k;
    if (added.eliminated > 0 || k < kMaps / 2) continue;
    ++deferred;
    if (deferred % 10 == 0) worst = std::max(worst, added.chi2 / testing::batch_chi2(updates, k) - 1.0);
  }
  EXPECT_GT(deferred, 50u);
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(worst, 1e-7);  // something was deferred
}

}  // namespace
}  // namespace mapjoin
