// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>

namespace mapjoin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

template <typename D>
class ConnectivityTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  /// Poses 10, 11, … and features 20, 21, … with nothing between them.
  static Log<D::value> bare(std::uint64_t poses, std::uint64_t features) {
    Log<D::value> log;
    log.source = "robot.g2o";
    for (std::uint64_t k = 0; k < poses; ++k) log.poses.push_back({0, 10 + k});
    for (std::uint64_t k = 0; k < features; ++k) log.features.push_back({20 + k});
    return log;
  }
  /// What check_connected() says of the log with measurements that are sound.
  static std::string complaint(Log<D::value> log) {
    for (auto& factor : log.graph.pose_factors) factor.information.setIdentity();
    for (auto& factor : log.graph.feature_factors) {
      factor.measured.setZero();
      factor.information.setIdentity();
    }
    put_in_order(log);
    return testing::error_of(check_connected(log));
  }
};
TYPED_TEST_SUITE(ConnectivityTest, testing::Dimensions);

TYPED_TEST(ConnectivityTest, ALogHangsTogetherByAnythingThatMentionsTwo) {
  auto log = this->bare(5, 2);
  log.graph.pose_factors = {{0, 1, {}, {}}, {2, 1, {}, {}}, {kWorld, 4, {}, {}}};
  log.graph.feature_factors = {{2, 0, {}, {}}, {3, 0, {}, {}}, {3, 1, {}, {}}, {kWorld, 1, {}, {}}};
  EXPECT_EQ(this->complaint(log), "");
}

TYPED_TEST(ConnectivityTest, PartsHaveTheirFactorsAsTheyAre) {
  constexpr int kDim = TestFixture::kDim;
  auto log = this->bare(4, 1);
  log.graph.pose_factors = {{0, 1, {}, PoseMatrix<kDim>::Identity(), Loss::truncated(9.0)},
                            {2, 3, {}, PoseMatrix<kDim>::Identity(), Loss::truncated(4.0)}};
  log.graph.feature_factors = {{3, 0, Point<kDim>::Ones(), PointMatrix<kDim>::Identity(), Loss::truncated(1.0)}};
  const auto parts = split_into_parts(log);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].edges()[0].loss, Loss::truncated(9.0));
  EXPECT_EQ(parts[1].edges()[0].loss, Loss::truncated(4.0));
  ASSERT_EQ(parts[1].observations().size(), 1U);
  EXPECT_EQ(parts[1].observations()[0].loss, Loss::truncated(1.0));
  EXPECT_EQ(parts[1].observations()[0].measured, Point<kDim>::Ones());
}

TYPED_TEST(ConnectivityTest, AdvisesToAssociateWherePartsHaveFeatures) {
  auto log = this->bare(2, 2);
  log.graph.feature_factors = {{0, 0, {}, {}}, {0, 1, {}, {}}};
  EXPECT_THAT(this->complaint(log), AllOf(HasSubstr("nothing ties its 2 parts"), Not(HasSubstr("--associate"))));
  log.graph.feature_factors[1].base = 1;
  EXPECT_THAT(this->complaint(log), HasSubstr("--associate ties them by features that they share"));
}

TYPED_TEST(ConnectivityTest, OnePoseAloneHangsTogether) {
  EXPECT_EQ(this->complaint(this->bare(1, 0)), "");
}

TYPED_TEST(ConnectivityTest, NamesOnePoseOfEachPart) {
  auto log = this->bare(4, 0);
  log.graph.pose_factors = {{0, 1, {}, {}}, {2, 3, {}, {}}};
  EXPECT_THAT(this->complaint(log), AllOf(HasSubstr("robot.g2o: "), HasSubstr("2 parts"), HasSubstr("pose 10"),
                                          HasSubstr("pose 12"), Not(HasSubstr("…"))));
}

TYPED_TEST(ConnectivityTest, NamesTheFirstFewOfManyParts) {
  auto log = this->bare(7, 0);
  log.graph.pose_factors = {{0, 1, {}, {}}};
  EXPECT_THAT(this->complaint(log), AllOf(HasSubstr("6 parts"), HasSubstr("pose 10, pose 12, pose 13, …")));
}

TYPED_TEST(ConnectivityTest, PosesWithoutEdgesAreNoLog) {
  auto log = this->bare(6, 1);
  EXPECT_THAT(this->complaint(log), HasSubstr("robot.g2o: has poses, but no edges"));
  log.graph.fixed = {{0, {}}};
  EXPECT_THAT(this->complaint(log), HasSubstr("robot.g2o: has poses, but no edges"));
}

TYPED_TEST(ConnectivityTest, TheWorldTiesWhatItFixes) {
  auto log = this->bare(3, 0);
  log.graph.pose_factors = {{1, 2, {}, {}}};
  log.graph.fixed = {{0, {}}};
  EXPECT_THAT(this->complaint(log), HasSubstr("they hold pose 10, pose 11"));
  log.graph.fixed = {{0, {}}, {1, {}}};
  EXPECT_EQ(this->complaint(log), "");
}

TYPED_TEST(ConnectivityTest, NamesAFeatureThatNothingObserves) {
  auto log = this->bare(1, 2);
  log.graph.feature_factors = {{0, 0, {}, {}}};
  EXPECT_THAT(this->complaint(log), HasSubstr("feature 21 is never observed"));
}

TYPED_TEST(ConnectivityTest, MapsHangTogetherByWhatTheyShare) {
  SubmapSet<TypeParam::value> set;
  set.source = "maps";
  for (std::uint64_t k = 0; k < 4; ++k) set.poses.push_back({0, k});
  set.features = {{7}};
  set.graph.submaps.resize(2);
  set.graph.submaps[0].base = 0;
  set.graph.submaps[0].poses = {1};
  set.graph.submaps[1].base = 2;
  set.graph.submaps[1].poses = {3};
  set.graph.submaps[1].features = {0};
  EXPECT_THAT(check_connected(set).error().message, AllOf(HasSubstr("pose 0"), HasSubstr("pose 2")));
  set.graph.submaps[0].features = {0};
  EXPECT_TRUE(check_connected(set));
  set.graph.submaps[0].features.clear();
  set.graph.pose_factors = {{3, 0, {}, {}}};
  EXPECT_TRUE(check_connected(set));
}

}  // namespace
}  // namespace mapjoin
