// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/association/identity_search.hpp>
#include <tests/support/pair_score.hpp>
#include <tests/support/wood.hpp>

namespace mapjoin {
namespace {

/// The log with a closure over every other pose, so that all of its segments are raw.
Log<2> with_closures(Log<2> log) {
  const std::vector<PoseFactor<2>> steps(log.odometry().begin(), log.odometry().end());
  for (std::size_t k = 1; k < steps.size(); ++k) {
    const Pose<2> both = compose(steps[k - 1].measured, steps[k].measured);
    log.graph.pose_factors.push_back({steps[k - 1].base, steps[k].target, both, steps[k].information});
  }
  return log;
}

TEST(IdentitySearchTest, UndoesAWrongMergeOfARawSegment) {
  const Log<2> log = with_closures(testing::wood<2>(1).log);
  const Split split = mapjoin::split(log, {SplitRule::kPoses, 20.0});
  for (const Segment& segment : split.segments) ASSERT_FALSE(segment.is_map);
  const auto sightings = sightings_of(log, split);
  // Two features of one segment swap their ids.
  constexpr std::size_t kSegment = 3;
  std::vector<FeatureIndex> names;
  std::vector<FeatureIndex> swapped;
  for (std::size_t s = 0; s < sightings.size(); ++s) {
    names.push_back(log.observations()[s].target);
    if (sightings[s].map == kSegment && swapped.size() < 2 && !std::ranges::count(swapped, names[s]))
      swapped.push_back(names[s]);
  }
  std::vector<std::size_t> labels;
  std::vector<std::vector<Point<2>>> scans(log.poses.size());
  for (std::size_t s = 0; s < sightings.size(); ++s) {
    FeatureIndex label = names[s];
    if (sightings[s].map == kSegment && label == swapped[0]) {
      label = swapped[1];
    } else if (sightings[s].map == kSegment && label == swapped[1]) {
      label = swapped[0];
    }
    labels.push_back(label.position());
    scans[sightings[s].scan].push_back(log.observations()[s].measured);
  }
  const std::stop_token stop;
  const NeighbourDensity<2> density(scans);
  const AssociationOptions options;
  IdentitySearch<2> search(
      Identities(sightings, labels), std::vector<std::optional<Match>>(sightings.size()), density, options,
      [&](const Identities& known) { return estimate_of(renamed(log, known), split, stop); }, SearchGates::kWide, stop);
  ASSERT_TRUE(search.run());
  std::vector<std::pair<FeatureIndex, FeatureIndex>> joined;
  for (std::size_t s = 0; s < sightings.size(); ++s) joined.emplace_back(names[s], search.identities().feature_of(s));
  const auto score = testing::pair_score(joined);
  EXPECT_GE(score.precision, 0.999);
  EXPECT_GE(score.recall, 0.99);
}

}  // namespace
}  // namespace mapjoin
