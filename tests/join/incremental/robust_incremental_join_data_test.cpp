// SPDX-License-Identifier: BSD-3-Clause
// Logs with wrong closures, joined map by map: the closures left out in the end and the estimate, against the whole log at
// once.
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>
#include <tests/support/data.hpp>
#include <tests/support/updates_of.hpp>

namespace mapjoin {
namespace {

template <int Dim>
std::vector<ClosureName> rejected_of(const Log<Dim>& log, const Inliers<Log<Dim>>& inliers) {
  std::vector<ClosureName> names;
  for (const Rejected& one : inliers.rejected) {
    names.push_back({log.poses[one.misfit.from], log.poses[std::get<PoseIndex>(one.misfit.to)]});
  }
  std::ranges::sort(names);
  return names;
}

/// Expects the closures left out, chi2 and poses to be those by the inliers of the whole log.
template <int Dim>
void expect_same_end(const Log<Dim>& log, const RobustIncrementalJoin<Dim>& joined) {
  const auto inliers = find_inliers(log, RobustOptions{}).value();
  auto left_out = joined.left_out();
  std::ranges::sort(left_out);
  EXPECT_EQ(left_out, rejected_of(log, inliers));
  const auto batch = run(inliers.input, without_verdict()).value();
  EXPECT_NEAR(joined.estimate().chi2(), batch.chi2, 1e-6 * batch.chi2);
  EXPECT_EQ(joined.estimate().dof(), batch.dof);
  double farthest = 0.0;
  for (const PoseIndex p : indices(batch.map.poses)) {
    farthest = std::max(farthest, local(batch.map.poses[p], *joined.estimate().pose(batch.map.pose_ids[p])).norm());
  }
  EXPECT_LT(farthest, 5e-3);
}

struct PlantedGroup {
  const char* file;
  std::size_t count;
  std::uint64_t seed;
};
class PlantedMapByMap : public ::testing::TestWithParam<PlantedGroup> {};

TEST_P(PlantedMapByMap, EndsAsTheWholeLogDoes) {
  const auto& [file, count, seed] = GetParam();
  const auto end_of = [&, &count = count, &seed = seed]<int Dim>(const Log<Dim>& clean) {
    const Log<Dim> log = plant_wrong_closures(clean, ClosurePolicy::kRandom, count, seed).log;
    RobustIncrementalJoin<Dim> joined;
    int judged = 0;
    auto updates = testing::updates_of(log, 10.0);
    for (auto& update : updates) judged += joined.add(std::move(update)).value().is_judged ? 1 : 0;
    EXPECT_LT(judged, 20);
    joined.judge();
    EXPECT_GT(joined.left_out().size(), count * 9 / 10);
    expect_same_end(log, joined);
  };
  std::visit(end_of, open_log(testing::data_file(file)).value());
}
INSTANTIATE_TEST_SUITE_P(Robust, PlantedMapByMap,
                         ::testing::Values(PlantedGroup{"pose-graphs-2d/manhattanOlson3500.g2o.gz", 50, 1},
                                           PlantedGroup{"pose-graphs-2d/intel.g2o.gz", 50, 1},
                                           PlantedGroup{"pose-graphs-3d/smallGrid3D.g2o.gz", 10, 1}));

TEST(RobustIncrementalData, ALogThatIsThereAlreadyEndsAsMapByMap) {
  const auto clean = std::get<Log<2>>(open_log(testing::data_file("pose-graphs-2d/intel.g2o.gz")).value());
  const Log<2> log = plant_wrong_closures(clean, ClosurePolicy::kRandom, 50, 2).log;
  RobustIncrementalJoin<2> joined;
  EXPECT_TRUE(joined.add_all(testing::updates_of(log, 10.0)).value().is_judged);
  joined.judge();
  expect_same_end(log, joined);
}

/// A wrong closure between kept poses of a log of features.
TEST(RobustIncrementalData, AWrongClosureOfHugeInformationBendsNothing) {
  const auto clean = std::get<Log<2>>(open_log(testing::data_file("dlr/dlr_corrected.g2o.gz")).value());
  Log<2> log = clean;
  const IndexOf index_of(log.poses);
  const PoseFactor<2> wrong{
      *index_of({0, 1291}), *index_of({0, 1739}), {{0.00194, -0.1501}, Rotation<2>(0.04944)}, 5e4 * Matrix<3>::Identity(), {}};
  log.graph.pose_factors.push_back(wrong);
  put_in_order(log);
  RobustIncrementalJoin<2> joined;
  auto updates = testing::updates_of(log, 10.0);
  for (auto& update : updates) joined.add(std::move(update)).value();
  const std::vector<ClosureName> closures = {{log.poses[wrong.base], log.poses[wrong.target]}};
  EXPECT_EQ(joined.left_out(), closures);
  IncrementalJoin<2> without;
  auto others = testing::updates_of(log, 10.0);
  for (auto& update : others) {
    std::erase_if(update.graph.pose_factors, [](const auto& o) { return o.information(0, 0) == 5e4; });
    without.add(std::move(update)).value();
  }
  EXPECT_NEAR(joined.estimate().chi2(), without.chi2(), 1e-3 * without.chi2());
}

}  // namespace
}  // namespace mapjoin
