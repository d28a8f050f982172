// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/join/study/comparison.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

template <typename T>
class ComparisonOfASmallWorld : public ::testing::Test {
 protected:
  static constexpr int Dim = T::value;

  Expected<Comparison<Dim>> compared(const Truth<Dim>* truth = nullptr) {
    ComparisonOptions<Dim> options;
    options.cases = compared_cases({5, 10});
    options.truth = truth;
    return compare(world.log, options);
  }

  SmallWorld<Dim> world = small_world<Dim>();
};
TYPED_TEST_SUITE(ComparisonOfASmallWorld, Dimensions);

TYPED_TEST(ComparisonOfASmallWorld, EveryWayEndsInTheSameMap) {
  const auto comparison = this->compared();
  ASSERT_TRUE(comparison) << comparison.error().message;
  ASSERT_EQ(comparison->cases.size(), 7U + 2U * 9U);
  const auto independent = solve(this->world.log, RunOptions{});
  for (const auto& figures : comparison->cases) {
    SCOPED_TRACE(to_string(figures.way));
    EXPECT_TRUE(figures.has_map()) << figures.failure;
    EXPECT_TRUE(figures.reaches_best);
    EXPECT_NEAR(figures.polished.chi2, independent->chi2, 1e-6);
    EXPECT_LT(figures.polished.from_best.poses.translation.max, 1e-5);
    EXPECT_LT(figures.polished.from_best.features.max, 1e-5);
    EXPECT_EQ(figures.polished.from_best.unmatched, 0U);
    EXPECT_GT(figures.run.joint_bytes, 0);
  }
}

TYPED_TEST(ComparisonOfASmallWorld, TheBestIsAtNoDistanceFromItself) {
  const auto comparison = this->compared();
  const auto& best = comparison->cases[comparison->best];
  for (const auto& figures : comparison->cases) EXPECT_GE(figures.polished.chi2, best.polished.chi2);
  EXPECT_TRUE(best.reaches_best);
  EXPECT_EQ(best.polished.from_best.poses.translation.max, 0.0);
  EXPECT_EQ(best.polished.from_best.features.max, 0.0);
  for (const PoseErrorSummary& span : best.polished.best_spans) EXPECT_EQ(span.translation.max, 0.0);
}

TYPED_TEST(ComparisonOfASmallWorld, JoiningAloneIsCloseToTheBestAndFullSlamIsThere) {
  const auto comparison = this->compared();
  for (const auto& figures : comparison->cases) {
    SCOPED_TRACE(to_string(figures.way));
    if (figures.way.is_full_slam()) {
      EXPECT_EQ(figures.joined.chi2, figures.polished.chi2);
      EXPECT_EQ(figures.polish_iterations(), 0);
    } else {
      // Interior poses were eliminated at the local linearisation, so that the joined map is near the optimum, not at it.
      EXPECT_GT(figures.joined.chi2, figures.polished.chi2);
      EXPECT_GT(figures.joined.from_best.poses.translation.max, 1e-6);
      EXPECT_LT(figures.joined.from_best.poses.translation.max, 0.05);
    }
  }
}

/// The RMS of the translations of (b_i⁻¹ b_{i+s})⁻¹ (a_i⁻¹ a_{i+s}) for a span of s poses, by transformation matrices (m).
template <int Dim>
double relative_translation_rms(const std::vector<Pose<Dim>>& a, const std::vector<Pose<Dim>>& b, std::size_t span) {
  const auto matrix = [](const Pose<Dim>& pose) {
    Eigen::Matrix<double, Dim + 1, Dim + 1> T = Eigen::Matrix<double, Dim + 1, Dim + 1>::Identity();
    T.template topLeftCorner<Dim, Dim>() = pose.rotation.matrix();
    T.template topRightCorner<Dim, 1>() = pose.translation;
    return T;
  };
  double sum = 0.0;
  for (std::size_t i = 0; i + span < a.size(); ++i) {
    const auto motion_a = (matrix(a[i]).inverse() * matrix(a[i + span])).eval();
    const auto motion_b = (matrix(b[i]).inverse() * matrix(b[i + span])).eval();
    sum += (motion_b.inverse() * motion_a).eval().template topRightCorner<Dim, 1>().squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.size() - span));
}

TYPED_TEST(ComparisonOfASmallWorld, TheRelativePoseMetricIsThatOfMatricesByHand) {
  constexpr int Dim = TypeParam::value;
  Truth<Dim> truth;
  for (const auto& pose : this->world.truth.poses) truth.poses.emplace_back(pose);
  truth.features.resize(this->world.log.features.size());
  const auto comparison = this->compared(&truth);
  EXPECT_EQ(comparison->spans, (std::vector<std::size_t>{1, 2, 5, 10, 20}));
  const auto& best = comparison->maps[comparison->best].polished.poses;
  for (std::size_t c = 0; c < comparison->cases.size(); ++c) {
    const CaseFigures& figures = comparison->cases[c];
    const auto& maps = comparison->maps[c];
    for (std::size_t k = 0; k < comparison->spans.size(); ++k) {
      const std::size_t span = comparison->spans[k];
      EXPECT_NEAR(figures.joined.best_spans[k].translation.rms, relative_translation_rms(maps.joined.poses, best, span), 1e-9);
      EXPECT_NEAR(figures.polished.from_truth->spans[k].translation.rms,
                  relative_translation_rms(maps.polished.poses, this->world.truth.poses, span), 1e-9);
    }
    EXPECT_GT(figures.polished.from_truth->absolute.translation.rms, 0.0);
    EXPECT_LT(figures.polished.from_truth->absolute.translation.rms, 0.1);
  }
}

TYPED_TEST(ComparisonOfASmallWorld, ATruthOfSomePosesCountsThoseOnly) {
  constexpr int Dim = TypeParam::value;
  Truth<Dim> truth;
  truth.poses.resize(this->world.log.poses.size());
  truth.features.resize(this->world.log.features.size());
  for (PoseIndex p = 0; p < 7; ++p) truth.poses[p] = this->world.truth.poses[p];
  const auto comparison = this->compared(&truth);
  const auto& known = *comparison->cases.front().polished.from_truth;
  EXPECT_EQ(known.absolute.translation.count, 7U);
  EXPECT_EQ(known.spans[2].translation.count, 2U);  // the span of 5 steps
  EXPECT_EQ(known.spans[3].translation.count, 0U);  // the span of 10
}

TYPED_TEST(ComparisonOfASmallWorld, RelativeErrorsAreWithinASession) {
  constexpr int Dim = TypeParam::value;
  Log<Dim>& log = this->world.log;
  const std::size_t first = log.poses.size() / 3;
  const std::size_t second = log.poses.size() - first;
  for (PoseIndex p(first); p < PoseIndex(first + second); ++p) log.poses[p].session = 1;
  put_in_order(log);
  Truth<Dim> truth;
  for (const auto& pose : this->world.truth.poses) truth.poses.emplace_back(pose);
  truth.features.resize(log.features.size());
  const auto comparison = this->compared(&truth);
  ASSERT_TRUE(comparison) << comparison.error().message;
  EXPECT_GT(comparison->spans.back(), first);
  EXPECT_LT(comparison->spans.back(), second);
  for (std::size_t k = 0; k < comparison->spans.size(); ++k) {
    const std::size_t span = comparison->spans[k];
    const std::size_t pairs = (span < first ? first - span : 0) + second - span;
    for (const auto& figures : comparison->cases) {
      EXPECT_EQ(figures.joined.best_spans[k].translation.count, pairs);
      EXPECT_EQ(figures.polished.from_truth->spans[k].translation.count, pairs);
    }
  }
}

TYPED_TEST(ComparisonOfASmallWorld, EveryCaseIsAnnouncedInItsTurn) {
  constexpr int Dim = TypeParam::value;
  ComparisonOptions<Dim> options;
  options.cases = compared_cases({20});
  std::vector<std::size_t> announced;
  options.progress = [&](std::size_t k) { announced.push_back(k); };
  ASSERT_TRUE(compare(this->world.log, options));
  std::vector<std::size_t> all(options.cases.size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
  EXPECT_EQ(announced, all);
}

TYPED_TEST(ComparisonOfASmallWorld, ACaseThatGivesNoMapSaysWhy) {
  constexpr int Dim = TypeParam::value;
  ComparisonOptions<Dim> options;
  options.cases = {{10, JoinedState::kAbsolute, Schedule::kSequential, false},
                   {10, JoinedState::kAbsolute, Schedule::kTree, false}};
  options.most_sequential = 3;
  const auto comparison = compare(this->world.log, options);
  ASSERT_TRUE(comparison);
  EXPECT_EQ(comparison->cases[0].failure, "not tried: about 4 maps one by one take too long");
  EXPECT_FALSE(comparison->cases[0].reaches_best);
  EXPECT_EQ(comparison->best, 1U);
}

TYPED_TEST(ComparisonOfASmallWorld, WhatDoesNotConvergeDoesNotReachTheBest) {
  constexpr int Dim = TypeParam::value;
  ComparisonOptions<Dim> options;
  options.cases = compared_cases({10});
  options.solver.max_iterations = 1;
  const auto comparison = compare(this->world.log, options);
  ASSERT_TRUE(comparison);
  EXPECT_TRUE(std::any_of(comparison->cases.begin(), comparison->cases.end(),
                          [](const auto& figures) { return !figures.reaches_best; }));
  for (const auto& figures : comparison->cases) EXPECT_LE(figures.reaches_best, figures.run.converged());
}

TYPED_TEST(ComparisonOfASmallWorld, EndsWhereAStopIsRequested) {
  constexpr int Dim = TypeParam::value;
  std::stop_source source;
  ComparisonOptions<Dim> options;
  options.cases = compared_cases({10});
  options.progress = [&](std::size_t k) {
    if (k == 2) source.request_stop();
  };
  const auto comparison = compare(this->world.log, options, source.get_token());
  ASSERT_FALSE(comparison);
  EXPECT_EQ(comparison.error().kind, ErrorKind::kInterrupted);
}

TEST(Comparison, OfWhatNothingDeterminesIsBadInput) {
  LogBuilder<2> builder("free");
  PoseMatrix<2> W = PoseMatrix<2>::Identity();
  W(2, 2) = 0.0;  // no heading
  for (std::uint64_t p = 0; p < 4; ++p) builder.add_pose_edge({0, p}, {0, p + 1}, Pose<2>{{1.0, 0.0}, {}}, W);
  const Log<2> log = std::move(builder).finish().value();
  ComparisonOptions<2> options;
  options.cases = compared_cases({2});
  const auto comparison = compare(log, options);
  ASSERT_FALSE(comparison);
  EXPECT_EQ(comparison.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(comparison.error().message, ::testing::StartsWith("no case gives a map; the first: free: pose "));
}

TEST(ComparedCase, IsNamedInWords) {
  EXPECT_EQ(to_string(ComparedCase{}), "full SLAM, absolute, tree");
  EXPECT_EQ(to_string(ComparedCase{20, JoinedState::kRelative, Schedule::kBatch, true}),
            "joining, relative, maps of 20 steps, gradual batch");
}

}  // namespace
}  // namespace mapjoin::testing
