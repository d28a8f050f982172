// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <mapjoin/model/submap_set.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/stored_maps.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <typename D>
class SubmapSetTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  void SetUp() override {
    set.source = "in memory";
    for (std::uint64_t key = 0; key < 3; ++key) set.poses.push_back({0, key});
    for (std::uint64_t key = 0; key < 5; ++key) set.features.push_back({key});
    for (PoseIndex k = 0; k < 2; ++k) set.graph.submaps.push_back(testing::random_map<kDim>(random, {k, k + 1}, 5));
    set.graph.pose_factors.push_back(testing::random_pose_observation<kDim>(random, kWorld, 2));
    set.graph.feature_factors.push_back(testing::random_feature_observation<kDim>(random, 0, 4));
    set.graph.fixed.push_back({0, random.template pose<kDim>()});
  }
  /// The error of check_content() on the set after `change`.
  template <typename Change>
  std::string error(const Change& change) const {
    SubmapSet<kDim> changed = set;
    change(changed);
    const auto checked = check_content(changed);
    return checked ? "no error" : checked.error().message;
  }
  testing::Random random;
  SubmapSet<kDim> set;
};
TYPED_TEST_SUITE(SubmapSetTest, testing::Dimensions);

TYPED_TEST(SubmapSetTest, SegmentsFollowEachOtherAndHoldAllPoses) {
  auto set = this->set;
  set.graph.submaps.clear();
  const auto fault_of = [&](const std::vector<Segment>& segments) {
    set.segments = segments;
    return testing::error_of(check_segments(set));
  };
  EXPECT_EQ(fault_of({{0, 1, false}, {1, 2, false}}), "");
  EXPECT_EQ(fault_of({{0, 0, false}, {1, 2, false}}), "") << "sessions share no pose";
  EXPECT_EQ(fault_of({{0, 0, false}, {0, 0, false}, {0, 2, false}}), "") << "of features alone";
  EXPECT_EQ(fault_of({}), "in memory: pose 0 is in no segment");
  EXPECT_EQ(fault_of({{1, 2, false}}), "in memory: pose 0 is in no segment");
  EXPECT_EQ(fault_of({{0, 1, false}}), "in memory: pose 2 is in no segment");
  EXPECT_EQ(fault_of({{0, 0, false}, {2, 2, false}}), "in memory: pose 1 is in no segment");
  EXPECT_EQ(fault_of({{0, 2, false}, {0, 1, false}}), "in memory: pose 0 begins a segment, but is within the one before");
  EXPECT_EQ(fault_of({{0, 1, false}, {0, 2, false}}), "in memory: pose 0 begins a segment, but is within the one before");
  EXPECT_EQ(fault_of({{0, 3, false}}), "in memory: segment 1 is of poses that are not there");
  EXPECT_EQ(fault_of({{0, 1, false}, {1, 0, false}}), "in memory: segment 2 is of poses that are not there");
  set.poses.clear();
  EXPECT_EQ(fault_of({{0, 0, false}}), "in memory: there are no poses");
}

TYPED_TEST(SubmapSetTest, SegmentsAreThoseOfTheMaps) {
  auto set = this->set;
  EXPECT_EQ(testing::error_of(check_segments(set)), "in memory: 0 segments for 2 local maps");
  set.segments = {{0, 1, true}, {1, 1, false}, {1, 2, true}};
  EXPECT_EQ(testing::error_of(check_segments(set)), "");
  set.graph.submaps[1].base = 0;
  const char* const wrong = "in memory: pose 1 begins a segment, but not a local map of all its poses in their order";
  EXPECT_EQ(testing::error_of(check_segments(set)), wrong);
  set.graph.submaps[1].base = 1;
  set.graph.submaps[1].poses = {};
  EXPECT_EQ(testing::error_of(check_segments(set)), wrong);
  set.segments = {{0, 0, false}, {0, 0, true}, {1, 2, true}};
  EXPECT_EQ(testing::error_of(check_segments(set)),
            "in memory: pose 0 begins a segment, but not a local map of all its poses in their order");
}

TYPED_TEST(SubmapSetTest, NumbersThatAreNoneAreNamed) {
  EXPECT_EQ(this->error([](auto&) {}), "no error");
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[1].information(0, 1) += 1.0; }),
              HasSubstr("in memory: local map 2 has an information matrix that is not symmetric"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].information *= -1.0; }),
              HasSubstr("local map 1 has an information matrix that"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].information(2, 2) = kNan; }), HasSubstr("is not finite"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].information.conservativeResize(4, 4); }),
              HasSubstr("has an information matrix of"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].pose_estimates[0].translation[0] = kNan; }),
              HasSubstr("is not finite"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].feature_estimates[3][1] = kNan; }), HasSubstr("is not finite"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].feature_estimates.pop_back(); }), HasSubstr("not as many as"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].chi2 = kNan; }), HasSubstr("has a chi2 that is not finite"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].poses[0] = 3; }),
              HasSubstr("local map 1 names a pose or feature that is not there"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].features[0] = -1; }),
              HasSubstr("local map 1 names a pose or feature that is not there"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.pose_factors[0].measured.translation[0] = kNan; }),
              MatchesRegex("in memory: pose factor 0, from the World to pose 2, has a measurement that is not finite.*"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.pose_factors[0].lever[0] = kNan; }),
              HasSubstr("has a lever that is not finite"));
  for (const Loss& loss : {Loss{kNan, 1.0}, Loss{1.0, kNan}, Loss{2.0, 1.0}, Loss{0.0, 1.0}, Loss{-2.0, -1.0},
                           Loss{1.0, std::numeric_limits<double>::infinity()}, Loss{1e200, 1e200}, Loss{1e-200, 1e-200}}) {
    EXPECT_THAT(this->error([&](auto& s) { s.graph.pose_factors[0].loss = loss; }),
                HasSubstr("has a loss whose ends are not 0 < quadratic_to <= constant_from, or have no "
                          "finite product above 0"));
  }
  EXPECT_THAT(this->error([](auto& s) { s.graph.feature_factors[0].information *= -1.0; }),
              HasSubstr("has an information matrix that is indefinite"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.feature_factors[0].target = 5; }),
              HasSubstr("names a pose or feature that is not there"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.fixed[0].value.translation[0] = kNan; }),
              HasSubstr("pose 0 is fixed at a value that is not finite, or no rotation"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.fixed[0].pose = 3; }), HasSubstr("a fixed pose is not there"));
}

TYPED_TEST(SubmapSetTest, NothingIsNamedOrFixedTwice) {
  EXPECT_THAT(this->error([](auto& s) { s.poses[2] = s.poses[0]; }), HasSubstr("in memory: it names pose 0 twice"));
  EXPECT_THAT(this->error([](auto& s) { s.features[3] = s.features[1]; }), HasSubstr("it names feature 1 twice"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[0].poses[0] = s.graph.submaps[0].base; }),
              HasSubstr("local map 1 has pose 0 twice"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.submaps[1].features[4] = s.graph.submaps[1].features[2]; }),
              HasSubstr("local map 2 has feature 2 twice"));
  EXPECT_THAT(this->error([](auto& s) { s.graph.pose_factors[0].base = 2; }),
              HasSubstr("from pose 2 to pose 2, leads from a pose to itself"));
  EXPECT_EQ(this->error([](auto& s) { s.graph.fixed.push_back(s.graph.fixed[0]); }), "no error");
  EXPECT_THAT(this->error([](auto& s) {
    s.graph.fixed.push_back(s.graph.fixed[0]);
    s.graph.fixed[1].value.translation[0] += 1.0;
  }),
              HasSubstr("pose 0 is fixed at two places"));
}

}  // namespace
}  // namespace mapjoin
