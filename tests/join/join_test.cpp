// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/build.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/every.hpp>
#include <tests/support/small_submap_set.hpp>
#include <tests/support/small_world.hpp>
#include <utility>

namespace mapjoin {
namespace {

using testing::largest_difference;
using testing::small_world;

template <typename D>
class JoinTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static Values<kDim> state_of(const RunResult<kDim>& result) { return {result.map.poses, result.map.features}; }
  /// The submap graph of a set with its submap-local features, which submap_graph_of() eliminates.
  static SubmapGraph<kDim> restored(const SubmapSet<kDim>& set) {
    SubmapGraph<kDim> graph = submap_graph_of(set);
    graph.maps.clear();
    for (const auto& map : set.graph.submaps) graph.maps.push_back({map, {}, {}, {}, {}});
    graph.is_local.assign(graph.is_local.size(), false);
    return graph;
  }
};
TYPED_TEST_SUITE(JoinTest, testing::Dimensions);

TYPED_TEST(JoinTest, FindsTheOptimumThatCeresFindsByEverySchedule) {
  constexpr int kDim = TestFixture::kDim;
  const auto set = testing::small_submap_set(small_world<kDim>({.poses = 60, .features = 40}).log, 8.0);
  for (const auto schedule : testing::every<Schedule>()) {
    RunOptions options;
    options.schedule = schedule;
    const auto joined = run(set, options);
    ASSERT_TRUE(joined) << joined.error().message;
    EXPECT_TRUE(joined->converged());
    const auto ceres = testing::ceres_optimum(set, this->state_of(*joined));
    EXPECT_NEAR(ceres.chi2, joined->chi2, 1e-9 * joined->chi2) << to_string(schedule);
    EXPECT_LT(largest_difference(ceres.values, this->state_of(*joined)), 1e-5);
  }
}

TYPED_TEST(JoinTest, MarginalisingLocalFeaturesChangesNothing) {
  constexpr int kDim = TestFixture::kDim;
  const auto set = testing::small_submap_set(small_world<kDim>({.features = 40, .range = 2.5}).log, 10.0);
  const SubmapGraph<kDim> marginalised = submap_graph_of(set);
  const SubmapGraph<kDim> joined_map = this->restored(set);
  ASSERT_GT(std::count(marginalised.is_local.begin(), marginalised.is_local.end(), true), 0);
  const auto a = join(marginalised, set.poses, set.features, JoinOptions<kDim>{});
  const auto b = join(joined_map, set.poses, set.features, JoinOptions<kDim>{});
  ASSERT_TRUE(a && b);
  EXPECT_LT(a->features.size(), b->features.size());
  EXPECT_NEAR(a->result.chi2, b->result.chi2, 1e-9 * b->result.chi2);
  EXPECT_EQ(a->result.dof, b->result.dof);
  EXPECT_LT(largest_difference(a->state, b->state), 1e-7);
}

TYPED_TEST(JoinTest, SaysHowEveryMapFits) {
  constexpr int kDim = TestFixture::kDim;
  auto set =
      testing::small_submap_set(small_world<kDim>({.poses = 60, .features = 40, .closures = 0, .noise = 0.01}).log, 10.0);
  const auto right = run(set, RunOptions{});
  ASSERT_TRUE(right);
  ASSERT_EQ(right->maps.size(), set.graph.submaps.size());
  double chi2 = 0.0;
  std::int64_t rows = 0;
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    EXPECT_EQ(right->maps[m].base, set.graph.submaps[m].base);
    EXPECT_GT(right->maps[m].probability(), 0.01) << m;
    chi2 += right->maps[m].chi2;
    rows += right->maps[m].rows;
  }
  EXPECT_NEAR(chi2, right->chi2, 1e-9 * chi2);
  EXPECT_EQ(rows - right->join.dof, join(submap_graph_of(set), set.poses, set.features, {})->system->equations().size());

  for (auto& feature : set.graph.submaps[3].feature_estimates) feature[0] += 0.3;  // against the maps on both sides
  const auto wrong = run(set, RunOptions{});
  ASSERT_TRUE(wrong);
  EXPECT_LT(wrong->maps[3].probability(), 1e-6);
  EXPECT_GT(wrong->maps[0].probability(), 0.01);
}

TYPED_TEST(JoinTest, SaysWhereEveryMapEnds) {
  const auto set = testing::small_submap_set(small_world<TestFixture::kDim>({.poses = 60, .closures = 8}).log, 10.0);
  const auto joined = run(set, RunOptions{});
  ASSERT_TRUE(joined);
  std::size_t most = 0;
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    EXPECT_EQ(joined->maps[m].end, set.graph.submaps[m].poses.back());
    most = std::max(most, set.graph.submaps[m].poses.size());
  }
  EXPECT_GT(most, 1u);  // some maps keep other poses, too
}

TYPED_TEST(JoinTest, AClosureMayLeadEitherWay) {
  constexpr int kDim = TestFixture::kDim;
  auto set = testing::small_submap_set(small_world<kDim>({.features = 0, .closures = 1, .noise = 0.0}).log, 8.0);
  for (int way = 0; way < 2; ++way) {
    const auto joined = run(set, RunOptions{});
    ASSERT_TRUE(joined);
    EXPECT_LT(joined->chi2, 1e-12);
    auto& closure = set.graph.pose_factors[0];
    std::swap(closure.base, closure.target);
    closure.measured = inverse(closure.measured);
  }
}

TYPED_TEST(JoinTest, MapsThatObserveFromOnePoseAreAllJoined) {
  // The first map has no motion, as some authors have them: its end is its base, and that of the next map.
  constexpr int kDim = TestFixture::kDim;
  testing::Random random(3);
  SubmapSet<kDim> set;
  set.poses = {{0, 0}, {0, 1}};
  set.features = {{0}, {1}, {2}, {3}};
  const auto map_of = [&](std::vector<PoseIndex> poses, std::vector<FeatureIndex> features) {
    LocalMap<kDim> map{0, std::move(poses), std::move(features), {}, {}, {}};
    for (std::size_t p = 0; p < map.poses.size(); ++p) map.pose_estimates.push_back(random.pose<kDim>());
    for (std::size_t f = 0; f < map.features.size(); ++f) map.feature_estimates.push_back(random.vector<kDim>(3.0));
    const auto rows =
        static_cast<Eigen::Index>(map.poses.size()) * kPoseDof<kDim> + static_cast<Eigen::Index>(map.features.size()) * kDim;
    map.information = Eigen::MatrixXd::Identity(rows, rows);
    return map;
  };
  set.graph.submaps = {map_of({}, {0, 1, 2}), map_of({1}, {0, 1, 2, 3})};
  set.segments = {{0, 0, true}, {0, 1, true}};
  const auto joined = run(set, RunOptions{});
  ASSERT_TRUE(joined) << joined.error().message;
  double chi2 = 0.0;  // of the means of the two maps: half the squared differences
  for (std::size_t f = 0; f < 3; ++f) {
    const Point<kDim> difference = set.graph.submaps[0].feature_estimates[f] - set.graph.submaps[1].feature_estimates[f];
    chi2 += 0.5 * difference.squaredNorm();
  }
  EXPECT_NEAR(joined->chi2, chi2, 1e-9 * chi2);
  EXPECT_LT(local(joined->map.poses[1], set.graph.submaps[1].pose_estimates[0]).norm(), 1e-8);
}

TYPED_TEST(JoinTest, APoseOfASetThatIsFixedTwiceAtOnePlaceIsFixedOnce) {
  constexpr int kDim = TestFixture::kDim;
  auto set = testing::small_submap_set(small_world<kDim>().log, 5.0);
  set.graph.fixed = {{0, Pose<kDim>{}}};
  const auto once = run(set, RunOptions{}).value();
  set.graph.fixed.push_back(set.graph.fixed.front());
  const auto twice = run(set, RunOptions{}).value();
  EXPECT_EQ(twice.map.gauge, once.map.gauge);
  EXPECT_EQ(twice.dof, once.dof);
  EXPECT_EQ(twice.chi2, once.chi2);
}

TYPED_TEST(JoinTest, TakesTheMapsOfASetThatIsGivenAway) {
  constexpr int kDim = TestFixture::kDim;
  const auto world = small_world<kDim>();
  auto set = testing::small_submap_set(world.log, 5.0);
  ASSERT_FALSE(set.graph.pose_factors.empty());
  set.graph.pose_factors.push_back({kWorld, 0, Pose<kDim>{}, PoseMatrix<kDim>::Identity()});
  RunOptions options;
  options.covariances = true;
  const auto kept = run(set, options);
  const auto given = run(std::move(set), options);
  ASSERT_TRUE(kept && given);
  EXPECT_TRUE(set.graph.submaps.empty());
  EXPECT_EQ(given->chi2, kept->chi2);
  EXPECT_EQ(given->joint_bytes, kept->joint_bytes);
  ASSERT_EQ(given->map.poses.size(), kept->map.poses.size());
  for (const PoseIndex p : indices(kept->map.poses)) {
    EXPECT_EQ(given->map.poses[p].translation, kept->map.poses[p].translation);
  }
  // The covariances own all that they need, though the set is gone.
  Truth<kDim> truth;
  for (const auto& pose : kept->map.poses) truth.poses.push_back(pose);
  for (const auto& feature : kept->map.features) truth.features.push_back(feature);
  truth.poses.back()->translation[0] += 0.01;
  EXPECT_EQ(consistency(*given->covariances, truth).value().joint.value,
            consistency(*kept->covariances, truth).value().joint.value);
}

TYPED_TEST(JoinTest, ReportsEveryJoinOnTheWay) {
  constexpr int kDim = TestFixture::kDim;
  const auto set = testing::small_submap_set(small_world<kDim>().log, 5.0);
  for (const auto schedule : testing::every<Schedule>()) {
    std::size_t last = 0;
    std::size_t total = 0;
    RunOptions options;
    options.schedule = schedule;
    options.progress = [&](Stage stage, std::size_t done, std::size_t to_do) {
      if (stage == Stage::kCovariances) return;  // of the verdict, after the joins
      EXPECT_EQ(stage, Stage::kJoin);
      EXPECT_EQ(done, ++last);
      total = to_do;
    };
    ASSERT_TRUE(run(set, options));
    EXPECT_EQ(last, total) << to_string(schedule);
  }
}

}  // namespace
}  // namespace mapjoin
