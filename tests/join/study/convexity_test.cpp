// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <mapjoin/join/study/convexity.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <stdexcept>
#include <tests/join/study/posed_world.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using testing::small_world;

template <typename D>
class ConvexityTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  static ConvexityOptions options(StateSource source = StateSource::kDrift) {
    ConvexityOptions options;
    options.split = {SplitRule::kPoses, 6.0};
    options.source = source;
    options.pairs = 2;
    options.points = 21;
    return options;
  }
  static std::vector<double> ends_of(const FormulationFigures& figures) {
    std::vector<double> ends;
    for (const auto& line : figures.segments) ends.insert(ends.end(), {line.values.front(), line.values.back()});
    return ends;
  }

  Log<kDim> log_ = small_world<kDim>({.poses = 30, .features = 12}).log;
};
TYPED_TEST_SUITE(ConvexityTest, testing::Dimensions);

TYPED_TEST(ConvexityTest, LooksAtTheSamePairsInBothStates) {
  for (const StateSource source : {StateSource::kBox, StateSource::kDrift}) {
    const auto found = convexity(this->log_, this->options(source));
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->size(), 4u);
    for (std::size_t f = 0; f < 4; ++f) EXPECT_EQ((*found)[f].formulation, kFormulations[f]);
    for (const std::size_t f : {std::size_t{0}, std::size_t{2}}) {
      const auto absolute = this->ends_of((*found)[f]);
      const auto relative = this->ends_of((*found)[f + 1]);
      for (std::size_t k = 0; k < absolute.size(); ++k) EXPECT_NEAR(relative[k], absolute[k], 1e-9 * absolute[k]);
    }
  }
}

TYPED_TEST(ConvexityTest, EndsAtTheBestEstimateWhereAsked) {
  auto options = this->options();
  options.to_best = true;
  const auto found = convexity(this->log_, options);
  ASSERT_TRUE(found);
  for (const auto& figures : *found) {
    const double best = figures.first_step.best_chi2;
    EXPECT_NEAR(figures.segments[1].values.front(), best, 1e-2 * best) << to_string(figures.formulation);
  }
  const auto& full = found->front();
  EXPECT_NEAR(full.segments[1].values.front(), full.first_step.best_chi2, 1e-9 * full.first_step.best_chi2);
}

TYPED_TEST(ConvexityTest, OneStepIsAllWhereEverythingIsQuadratic) {
  auto options = this->options();
  options.split = {SplitRule::kPoses, 1.0};
  const auto found = convexity(testing::tree_world<TestFixture::kDim>(), options);
  ASSERT_TRUE(found) << found.error().message;
  const auto& relative = (*found)[1];
  ASSERT_TRUE(relative.first_step.share());
  EXPECT_NEAR(*relative.first_step.share(), 1.0, 1e-9);
  EXPECT_EQ(relative.curvature.violations + relative.curvature.negative, 0u);
  EXPECT_NEAR(relative.quadratic.information, 1.0, 1e-9);
  EXPECT_LT((*found)[0].quadratic.information, 0.9);
}

/// The local maps of a log, over the poses that they keep, without anything else of it.
template <int Dim>
SubmapSet<Dim> submap_set(const Log<Dim>& log, const SplitOptions& options) {
  Split parts = split(log, options);
  SubmapSet<Dim> set;
  set.graph.submaps = build_local_maps<Dim>(log, parts, {}).value().maps;
  Table<PoseIndex, PoseIndex> place(log.poses.size());
  for (const PoseIndex pose : indices(place)) {
    place[pose] = indices(set.poses).last;
    if (parts.kept[pose]) set.poses.push_back(log.poses[pose]);
  }
  set.features = log.features;
  for (auto& map : set.graph.submaps) {
    map.base = place[map.base];
    for (PoseIndex& pose : map.poses) pose = place[pose];
    set.segments.push_back({map.base, map.poses.back(), true});
  }
  return set;
}

TYPED_TEST(ConvexityTest, OfMapsAloneIsThatOfJoining) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = small_world<kDim>({.poses = 31, .features = 12, .closures = 0}).log;
  const auto options = this->options();
  const auto of_log = convexity(log, options);
  const auto of_maps = convexity(submap_set(log, options.split), options);
  ASSERT_TRUE(of_log && of_maps);
  ASSERT_EQ(of_maps->size(), 2u);
  for (std::size_t f = 0; f < 2; ++f) {
    const auto& here = (*of_maps)[f];
    const auto& there = (*of_log)[f + 2];
    EXPECT_EQ(here.formulation, there.formulation);
    EXPECT_EQ(here.quadratic.rows, there.quadratic.rows);
    EXPECT_EQ(here.quadratic.quadratic_rows, there.quadratic.quadratic_rows);
    EXPECT_NEAR(here.first_step.start_chi2, there.first_step.start_chi2, 1e-9 * there.first_step.start_chi2);
    EXPECT_NEAR(here.first_step.best_chi2, there.first_step.best_chi2, 1e-6 * there.first_step.best_chi2);
  }
}

TYPED_TEST(ConvexityTest, AStepLeadsFromTheComposedStartTowardsTheBest) {
  const auto found = convexity(this->log_, this->options());
  ASSERT_TRUE(found);
  for (const auto& figures : *found) {
    EXPECT_GT(figures.first_step.start_chi2, figures.first_step.best_chi2);
    ASSERT_TRUE(figures.first_step.share());
    EXPECT_GT(*figures.first_step.share(), 0.5) << to_string(figures.formulation);
    EXPECT_LE(*figures.first_step.share(), 1.0 + 1e-9);
  }
}

TYPED_TEST(ConvexityTest, IsTheSameForAnyNumberOfThreads) {
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return convexity(this->log_, this->options()).value();
  };
  const Convexity one = with_threads(1);
  const Convexity four = with_threads(4);
  for (std::size_t f = 0; f < one.size(); ++f) {
    for (std::size_t k = 0; k < one[f].segments.size(); ++k) EXPECT_EQ(one[f].segments[k].values, four[f].segments[k].values);
    EXPECT_EQ(one[f].quadratic.information, four[f].quadratic.information);
    EXPECT_EQ(one[f].first_step.chi2, four[f].first_step.chi2);
  }
}

TYPED_TEST(ConvexityTest, ReportsProgressAndIsInterrupted) {
  auto options = this->options();
  std::vector<std::size_t> done;
  options.progress = [&](std::size_t segment, std::size_t to_do) {
    done.push_back(segment);
    EXPECT_EQ(to_do, 8u);
  };
  ASSERT_TRUE(convexity(this->log_, options));
  EXPECT_THAT(done, ::testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  std::stop_source source;
  source.request_stop();
  const auto stopped = convexity(this->log_, options, source.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, ErrorKind::kInterrupted);
}

TYPED_TEST(ConvexityTest, RefusesOptionsAndLogsThatMakeNoSense) {
  auto options = this->options();
  options.points = 2;
  EXPECT_THROW((void)convexity(this->log_, options), std::invalid_argument);
  options = this->options();
  options.spread = -1.0;
  EXPECT_THAT(options.validate(), ::testing::ElementsAre("the spread must be a positive number"));
  LogBuilder<TestFixture::kDim> apart("two parts");
  const auto information = PoseMatrix<TestFixture::kDim>::Identity().eval();
  apart.add_pose_edge({0, 0}, {0, 1}, {}, information);
  apart.add_pose_edge({1, 0}, {1, 1}, {}, information);
  const auto found = convexity(std::move(apart).finish().value(), this->options());
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, ErrorKind::kBadInput);
}

}  // namespace
}  // namespace mapjoin
