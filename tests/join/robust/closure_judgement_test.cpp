// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/join/robust/closure_judgement.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin {
namespace {

template <typename D>
class ClosureJudgementTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
};
TYPED_TEST_SUITE(ClosureJudgementTest, testing::Dimensions);

TYPED_TEST(ClosureJudgementTest, TellsWhatCountsFromWhatAgreesAndFromWhatDoesNot) {
  constexpr int kDim = TypeParam::value;
  auto world = testing::small_world<kDim>({.poses = 30, .features = 0, .closures = 6});
  auto& factors = world.log.graph.pose_factors;
  const auto closures = factors.end() - 6;
  closures[2].measured.translation[0] += 5.0;
  closures[4].measured.translation[0] += 5.0;
  Log<kDim> some = world.log;
  std::erase_if(some.graph.pose_factors,
                [&](const auto& o) { return o.target == closures[2].target && o.base == closures[2].base; });
  some.graph.pose_factors.pop_back();  // closure 5
  const std::vector<std::size_t> chosen = {0, 1, 3, 4};

  TruncatedJoin<kDim> join(some, world.truth, {}, Engine::kFronts);
  Gates gates{{40.0, 40.0}, {1.0, 1.0}, {}};
  ASSERT_TRUE(settle(join, gates, "world", {}));
  const ClosureJudgement<kDim> judged = judge(world.log, chosen, join, gates, {});
  using enum Standing;
  EXPECT_EQ(judged.standing, (std::vector{kKept, kKept, kDropped, kKept, kDropped, kOpen}));
  for (const std::size_t k : {0U, 1U, 3U, 5U}) EXPECT_LT(judged.chi2[k], 40.0);
  for (const std::size_t k : {2U, 4U}) EXPECT_GT(judged.chi2[k], 40.0);
  EXPECT_EQ(judged.chi2[4], join.closure_tests()[3].chi2) << "exact for those that were chosen";
}

/// The closures that fit beyond chance, judged by a map.
template <typename D>
class FitsBeyondChanceTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// True for each closure that fits beyond chance. All standard deviations are 1 (m, rad), and the map predicts each closure
  /// to lead `predicted` metres ahead; the last one measured `measured_by_last` (m), the others nothing.
  std::vector<bool> fits(const std::vector<Standing>& standing, const std::vector<double>& chi2, double measured_by_last,
                         double predicted = 0.0, bool is_turned = false) {
    ClosureJudgement<kDim> judgement{standing, chi2, {}, {}};
    judgement.mismatches.resize(chi2.size(), {{}, PoseMatrix<kDim>::Identity()});
    judgement.values.poses.resize(2 * chi2.size());
    for (std::size_t k = 0; k < chi2.size(); ++k) judgement.values.poses[PoseIndex(2 * k + 1)].translation[0] = predicted;
    std::vector<PoseFactor<kDim>> closures;
    for (std::size_t k = 0; k < chi2.size(); ++k) {
      closures.push_back({PoseIndex(2 * k), PoseIndex(2 * k + 1), {}, PoseMatrix<kDim>::Identity()});
    }
    closures.back().measured.translation[0] = measured_by_last;
    if (is_turned) {  // stored from its later pose to its earlier one
      std::swap(closures.back().base, closures.back().target);
      closures.back().measured = inverse(closures.back().measured);
    }
    return fits_beyond_chance<kDim>(judgement, closures, {{25.0, 25.0}, {0.16, 1.0}, {}});
  }
};
TYPED_TEST_SUITE(FitsBeyondChanceTest, testing::Dimensions);

TYPED_TEST(FitsBeyondChanceTest, IsSoWithinTheWidestGateWhereNothingWrongWouldFit) {
  using enum Standing;
  EXPECT_EQ(this->fits({kDropped, kDropped, kOpen, kDropped}, {20.0, 24.0, 3.0, 90.0}, 5.1),
            (std::vector{true, true, true, false}));
}

TYPED_TEST(FitsBeyondChanceTest, IsNotSoBeyondTheNarrowGateWhereSomethingWrongWouldFit) {
  using enum Standing;
  EXPECT_EQ(this->fits({kDropped, kDropped, kOpen, kDropped}, {20.0, 5.0, 3.0, 90.0}, 4.9),
            (std::vector{false, false, true, false}));
}

TYPED_TEST(FitsBeyondChanceTest, IsSoWhereMoreThatIsRightLiesThereThanSomethingWrongWouldFit) {
  using enum Standing;
  EXPECT_EQ(this->fits({kKept, kKept, kDropped, kDropped}, {20.0, 20.0, 5.0, 90.0}, 4.9),
            (std::vector{true, true, true, false}));
  EXPECT_EQ(this->fits({kKept, kKept, kDropped, kDropped}, {20.0, 3.0, 5.0, 90.0}, 4.9),
            (std::vector{true, true, false, false}));
}

TYPED_TEST(FitsBeyondChanceTest, AsksInTheDirectionOfTheDrive) {
  using enum Standing;
  for (const bool is_turned : {false, true}) {
    EXPECT_EQ(this->fits({kDropped, kDropped, kOpen, kDropped}, {20.0, 5.0, 3.0, 90.0}, 8.0, 4.0, is_turned),
              (std::vector{false, false, true, false}));
  }
}

TYPED_TEST(FitsBeyondChanceTest, IsSoOfAllWhereThereIsNoMapYet) {
  using enum Standing;
  const auto closures = std::vector<PoseFactor<TestFixture::kDim>>(2, {0, 1, {}, PoseMatrix<TestFixture::kDim>::Identity()});
  const ClosureJudgement<TestFixture::kDim> judgement{{kOpen, kOpen}, {0.0, 0.0}, {}, {}};
  EXPECT_EQ(fits_beyond_chance<TestFixture::kDim>(judgement, closures, {{25.0, 25.0}, {0.0, 1.0}, {}}),
            (std::vector{true, true}));
}

TYPED_TEST(FitsBeyondChanceTest, IsSoOfWhatIsKept) {
  using enum Standing;
  EXPECT_EQ(this->fits({kKept, kKept, kOpen, kDropped}, {20.0, 5.0, 3.0, 90.0}, 0.0), (std::vector{true, true, true, false}));
}

TYPED_TEST(FitsBeyondChanceTest, AsksThoseOnlyThatAreContradicted) {
  using enum Standing;
  EXPECT_EQ(this->fits({kDropped, kDropped, kOpen, kDropped}, {20.0, 5.0, 3.0, 24.0}, 0.0),
            (std::vector{true, true, true, true}));
}

/// A hundred closures, evenly spread over the gate up to a chi2 of 20, beside `kept` ones between the gates and four hundred
/// contradicted ones, whose measurements would have a chi2 of 10 in the places of the hundred.
template <int Dim>
std::vector<bool> fits_of_a_hundred(std::size_t kept) {
  constexpr std::size_t kOpen = 100, kContradicted = 400;
  const std::size_t count = kOpen + kept + kContradicted;
  ClosureJudgement<Dim> judgement{std::vector(count, Standing::kDropped), std::vector(count, 90.0), {}, {}};
  judgement.mismatches.resize(count, {{}, PoseMatrix<Dim>::Identity()});
  judgement.values.poses.resize(2 * count);
  std::vector<PoseFactor<Dim>> closures;
  for (std::size_t k = 0; k < count; ++k) {
    closures.push_back({PoseIndex(2 * k), PoseIndex(2 * k + 1), {}, PoseMatrix<Dim>::Identity()});
    if (k < kOpen) {
      judgement.chi2[k] = 0.2 * static_cast<double>(k + 1);
    } else if (k < kOpen + kept) {
      judgement.standing[k] = Standing::kKept;
      judgement.chi2[k] = 20.0;
    } else {
      closures[k].measured.translation[0] = std::sqrt(10.1);
    }
  }
  std::vector<bool> fits = fits_beyond_chance<Dim>(judgement, closures, {{25.0, 25.0}, {0.16, 1.0}, {}, 0.99});
  fits.resize(kOpen);
  return fits;
}

TYPED_TEST(FitsBeyondChanceTest, IsSoOfWhatIsNearerThanContradictedOnesWouldBeIfManyRightOnesAreFar) {
  const std::vector<bool> fits = fits_of_a_hundred<TestFixture::kDim>(300);
  for (std::size_t k = 0; k < fits.size(); ++k) EXPECT_EQ(fits[k], k < 50) << k;
}

TYPED_TEST(FitsBeyondChanceTest, IsSoOnlyWithinTheNarrowGateIfFewRightOnesAreFar) {
  const std::vector<bool> fits = fits_of_a_hundred<TestFixture::kDim>(90);
  for (std::size_t k = 0; k < fits.size(); ++k) EXPECT_EQ(fits[k], k < 19) << k;
}

}  // namespace
}  // namespace mapjoin
