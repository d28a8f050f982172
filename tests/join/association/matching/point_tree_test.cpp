// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <numeric>
#include <span>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin {
namespace {

constexpr std::size_t kPoints = 500;

template <typename D>
class PointTreeTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  std::vector<Point<kDim>> points_ = [] {
    testing::Random random(4);
    std::vector<Point<kDim>> points(kPoints);
    for (auto& point : points) point = random.vector<kDim>(10.0);
    return points;
  }();
  Point<kDim> centre_ = Point<kDim>::Constant(1.0);
  PointTree<kDim> tree_{points_};

  double distance(std::size_t place) const { return (points_[place] - centre_).norm(); }
  std::vector<std::size_t> by_distance() const {
    std::vector<std::size_t> places(points_.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    std::ranges::sort(places, {}, [&](std::size_t place) { return distance(place); });
    return places;
  }
};
TYPED_TEST_SUITE(PointTreeTest, testing::Dimensions);

TYPED_TEST(PointTreeTest, FindsAllWithinADistance) {
  std::vector<std::size_t> expected;
  for (std::size_t place = 0; place < kPoints; ++place) {
    if (this->distance(place) < 4.0) expected.push_back(place);
  }
  ASSERT_GT(expected.size(), 5U);
  EXPECT_THAT(this->tree_.within(this->centre_, 4.0), ::testing::UnorderedElementsAreArray(expected));
}

TYPED_TEST(PointTreeTest, FindsSomeWithinADistance) {
  const auto all = this->tree_.within(this->centre_, 4.0);
  const auto some = this->tree_.some_within(this->centre_, 4.0, 3);
  EXPECT_EQ(some.size(), 3U);
  EXPECT_THAT(all, ::testing::IsSupersetOf(some));
  EXPECT_THAT(this->tree_.some_within(this->centre_, 4.0, kPoints), ::testing::UnorderedElementsAreArray(all));
}

TYPED_TEST(PointTreeTest, FindsTheNearestFirst) {
  auto expected = this->by_distance();
  EXPECT_EQ(this->tree_.nearest(this->centre_, kPoints + 1), expected);
  expected.resize(7);
  EXPECT_EQ(this->tree_.nearest(this->centre_, 7), expected);
}

TYPED_TEST(PointTreeTest, OfNoPointsFindsNone) {
  constexpr int kDim = TestFixture::kDim;
  const PointTree<kDim> tree{std::span<const Point<kDim>>{}};
  EXPECT_TRUE(tree.within(this->centre_, 4.0).empty());
  EXPECT_TRUE(tree.some_within(this->centre_, 4.0, 1).empty());
  EXPECT_TRUE(tree.nearest(this->centre_, 1).empty());
}

}  // namespace
}  // namespace mapjoin
