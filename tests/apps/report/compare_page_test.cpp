// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/report/compare_report.hpp>

namespace mapjoin::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A page of one way to the map of two poses.
class ComparePage : public ::testing::Test {
 protected:
  ComparePage() {
    map.pose_ids = {{0, 0}, {0, 1}};
    map.poses.resize(2);
    map.poses[1].translation.x() = 1.0;
  }
  std::string page() const {
    const Options options;
    Comparison<2> comparison;
    comparison.cases.resize(1);
    comparison.maps = {{map, map}};
    OtherWeights<2> with_map = other;
    with_map.map = map;
    return compare_page(RunReport("compare", options), comparison, with_map, {}, {{0, 2}});
  }

  GlobalMap<2> map;
  OtherWeights<2> other;
};

TEST_F(ComparePage, SaysWhereTheMapWithTheOtherWeightsIsNoOptimum) {
  EXPECT_THAT(page(), Not(HasSubstr("no optimum")));
  other.run.polish.emplace().status = MinimiseStatus::kMaxIterations;
  EXPECT_THAT(page(), HasSubstr("This map is no optimum: its solve did not converge: max_iterations."));
}

TEST_F(ComparePage, TellsOfFeaturesWhereThereAreAny) {
  EXPECT_THAT(page(), AllOf(HasSubstr("The best map: trajectory."), Not(HasSubstr("rings"))));
  EXPECT_THAT(page(), HasSubstr("Trajectories with the identity covariance and with the original covariance."));
  map.feature_ids.push_back({7});
  map.features.push_back(Point<2>(1.0, 1.0));
  other.from_best.features.count = 1;
  EXPECT_THAT(page(), HasSubstr("The best map: trajectory and features."));
  EXPECT_THAT(page(), HasSubstr("Trajectories, and features: rings with the identity covariance, dots with the original"));
}

}  // namespace
}  // namespace mapjoin::apps
