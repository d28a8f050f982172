// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <tests/support/small_world.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;

template <int Dim>
struct MeasuredEdge {
  Pose<Dim> measured;
  PoseMatrix<Dim> information;
};

/// The names of findings on two edges between poses 0 and 3, the second from 3 to 0 if it is `reversed`.
template <int Dim>
std::vector<std::string> found(const MeasuredEdge<Dim>& a, const MeasuredEdge<Dim>& b, bool reversed = false) {
  LogBuilder<Dim> builder("some.g2o");
  for (std::uint64_t k = 0; k < 3; ++k) builder.add_pose_edge({0, k}, {0, k + 1}, {}, PoseMatrix<Dim>::Identity());
  builder.add_pose_edge({0, 0}, {0, 3}, a.measured, a.information);
  builder.add_pose_edge({0, reversed ? 3u : 0u}, {0, reversed ? 0u : 3u}, b.measured, b.information);
  std::vector<std::string> checks;
  for (const Finding& finding : check_repeats(std::move(builder).finish().value())) {
    EXPECT_EQ(finding.where.names, std::vector<std::string>{"pose 0 to pose 3"});
    checks.push_back(finding.check);
  }
  return checks;
}

template <typename Dimension>
class Repeats : public ::testing::Test {};
TYPED_TEST_SUITE(Repeats, Dimensions);

TYPED_TEST(Repeats, AreNoneInALogThatSaysEverythingOnce) {
  EXPECT_TRUE(check_repeats(small_world<TypeParam::value>({.closures = 0}).log).empty());
}

TYPED_TEST(Repeats, TellCopiesFromSecondMeasurementsAndFromContradictions) {
  constexpr int Dim = TypeParam::value;
  Random random;
  const MeasuredEdge<Dim> edge{random.pose<Dim>(), 1e4 * random.information<kPoseDof<Dim>>()};
  const auto moved_by = [&](double metres) {
    MeasuredEdge<Dim> other = edge;
    other.measured.translation[0] += metres;
    return other;
  };
  EXPECT_THAT(found<Dim>(edge, edge), ElementsAre("copies"));
  EXPECT_THAT(found<Dim>(edge, moved_by(0.01)), ElementsAre("repeated"));
  EXPECT_THAT(found<Dim>(edge, moved_by(1.0)), ElementsAre("contradiction"));
}

TYPED_TEST(Repeats, ContradictEachOtherInAnyUnit) {
  constexpr int Dim = TypeParam::value;
  for (const double metres : {1.0, 1e-3, 1e-9}) {  // in a unit of translations
    PoseMatrix<Dim> W = 1e8 * PoseMatrix<Dim>::Identity();
    W.template topLeftCorner<Dim, Dim>() *= metres * metres;
    MeasuredEdge<Dim> other{{}, W};
    other.measured.translation[0] = 0.01 / metres;
    EXPECT_THAT(found<Dim>({{}, W}, other), ElementsAre("contradiction")) << metres;
  }
}

TYPED_TEST(Repeats, ContradictOnlyWhereChanceHardlyAllowsIt) {
  constexpr int Dim = TypeParam::value;
  const PoseMatrix<Dim> W = 1e4 * PoseMatrix<Dim>::Identity();  // 1 cm each, 1.41 cm of the difference
  const auto apart = [&](double sigmas) {
    Pose<Dim> other;
    other.translation[0] = sigmas * std::sqrt(2.0) * 0.01;
    return found<Dim>({{}, W}, {other, W});
  };
  EXPECT_THAT(apart(4.0), ElementsAre("repeated"));
  EXPECT_THAT(apart(9.0), ElementsAre("contradiction"));
  const auto by_chance = [](double probability) { return std::sqrt(chi_squared_quantile(1.0 - probability, kPoseDof<Dim>)); };
  EXPECT_THAT(apart(by_chance(3e-9)), ElementsAre("repeated"));
  EXPECT_THAT(apart(by_chance(3e-10)), ElementsAre("contradiction"));
}

TYPED_TEST(Repeats, AreComparedWhateverTheirDirection) {
  constexpr int Dim = TypeParam::value;
  Random random;
  const PoseMatrix<Dim> W = 1e4 * PoseMatrix<Dim>::Identity();
  const Pose<Dim> measured = random.pose<Dim>();
  EXPECT_THAT(found<Dim>({measured, W}, {inverse(measured), W}, true), ElementsAre("repeated"));
  EXPECT_THAT(found<Dim>({measured, W}, {measured, W}, true), ElementsAre("contradiction"));
}

TYPED_TEST(Repeats, WithoutInformationContradictNothing) {
  constexpr int Dim = TypeParam::value;
  Random random;
  PoseMatrix<Dim> W = PoseMatrix<Dim>::Zero();
  W(1, 1) = 1e6;  // along y only
  Pose<Dim> measured = random.pose<Dim>();
  Pose<Dim> other = measured;
  other.translation[0] += 100.0;
  EXPECT_THAT(found<Dim>({measured, W}, {other, W}), ElementsAre("repeated"));
  other.translation[1] += 1.0;
  EXPECT_THAT(found<Dim>({measured, W}, {other, W}), ElementsAre("contradiction"));
}

TYPED_TEST(Repeats, OfObservationsNameFeatureAndPose) {
  constexpr int Dim = TypeParam::value;
  LogBuilder<Dim> builder("some.g2o");
  builder.add_pose_edge({0, 0}, {0, 1}, {}, PoseMatrix<Dim>::Identity());
  for (const double x : {1.0, 9.0}) {
    builder.add_observation({0, 1}, {7}, x * Point<Dim>::Ones(), 1e4 * PointMatrix<Dim>::Identity());
  }
  const Findings findings = check_repeats(std::move(builder).finish().value());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].check, "contradiction");
  EXPECT_THAT(findings[0].where.names, ElementsAre("feature 7 from pose 1"));
}

}  // namespace
}  // namespace mapjoin::testing
