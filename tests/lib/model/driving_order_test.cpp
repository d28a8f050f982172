// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <tests/lib/model/built_log_fixture.hpp>
#include <tests/support/dimensions.hpp>

namespace mapjoin {
namespace {

using ::testing::ElementsAre;
using testing::marks;

using Edges = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

/// A drive over a few poses, some of whose ids are swapped, and closures, some of whose edges are swapped.
Edges swapped_drive(std::mt19937& random) {
  const auto swap_some = [&](auto& items) {
    for (unsigned swaps = random() % 4; swaps > 0; --swaps) {
      std::swap(items[random() % items.size()], items[random() % items.size()]);
    }
  };
  std::vector<std::uint64_t> ids(3 + random() % 5);
  std::iota(ids.begin(), ids.end(), 0);
  swap_some(ids);
  Edges edges;
  for (std::size_t k = 1; k < ids.size(); ++k) edges.emplace_back(ids[k - 1], ids[k]);
  for (unsigned closures = random() % 4; closures > 0; --closures) {
    const std::size_t base = random() % ids.size();
    edges.emplace_back(ids[base], ids[(base + 1 + random() % (ids.size() - 1)) % ids.size()]);
  }
  swap_some(edges);
  return edges;
}

template <typename D>
class DrivingOrderTest : public testing::BuiltLogTest<D> {};
TYPED_TEST_SUITE(DrivingOrderTest, testing::Dimensions);

TYPED_TEST(DrivingOrderTest, WhereIdsSayNothingOfTheOrderEdgesDo) {
  // Poses driven as 7, 2, 9, 4, 0, 5, with closures 9 to 5 and 5 to 7.
  for (const auto& [base, target] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{{7, 2}, {2, 9}, {9, 4}, {4, 0}}) {
    this->edge({0, base}, {0, target});
  }
  this->edge({0, 0}, {0, 5}, 3);
  this->edge({0, 9}, {0, 5}, 1);
  this->edge({0, 5}, {0, 7}, 2);
  for (const std::uint64_t pose : {4u, 7u, 5u}) this->observe(pose, 1, static_cast<double>(pose));
  this->builder.fix({0, 7}, Pose<TestFixture::kDim>{});
  this->builder.fix({0, 0}, Pose<TestFixture::kDim>{});
  for (const std::uint64_t pose : {0u, 2u, 4u, 5u, 7u, 9u}) this->builder.add_stamp({0, pose}, static_cast<std::int64_t>(pose));
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_THAT(log->poses, ElementsAre(PoseId{0, 7}, PoseId{0, 2}, PoseId{0, 9}, PoseId{0, 4}, PoseId{0, 0}, PoseId{0, 5}));
  ASSERT_EQ(log->sessions.size(), 1u);
  EXPECT_THAT(marks(log->odometry()), ElementsAre(0, 0, 0, 0, 3));
  EXPECT_THAT(marks(log->closures()), ElementsAre(1, 2));
  EXPECT_EQ(log->closures()[0].base, PoseIndex(2));
  EXPECT_EQ(log->closures()[0].target, PoseIndex(5));
  EXPECT_THAT(marks(log->observations()), ElementsAre(7, 4, 5));
  EXPECT_THAT(log->stamps_ns, ElementsAre(7, 2, 9, 4, 0, 5));
  EXPECT_EQ(log->graph.fixed[0].pose, PoseIndex(0));
  EXPECT_EQ(log->graph.fixed[1].pose, PoseIndex(4));
  EXPECT_EQ(IndexOf(log->poses)(PoseId{0, 9}), PoseIndex(2));
  EXPECT_EQ(IndexOf(log->poses)(PoseId{0, 3}), std::nullopt);
}

TYPED_TEST(DrivingOrderTest, IdsTellTheOrderWhereEdgesDoNotTellItBetter) {
  // Edges of two drives and of a closure between them, shuffled.
  for (const auto& [base, target] :
       std::vector<std::pair<std::uint64_t, std::uint64_t>>{{3, 4}, {0, 1}, {4, 5}, {1, 2}, {5, 0}}) {
    this->edge({0, base}, {0, target});
  }
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_TRUE(std::is_sorted(log->poses.begin(), log->poses.end()));
  EXPECT_EQ(log->sessions.size(), 2u);
}

TYPED_TEST(DrivingOrderTest, EdgesTellTheOrderWhereIdsAreSwapped) {
  // Poses driven as 0, 1, 3, 2, 4, 5, as if sensors were out of step; pose 6 is on no drive.
  double mark = 0.0;
  for (const auto& [base, target] :
       std::vector<std::pair<std::uint64_t, std::uint64_t>>{{0, 1}, {1, 3}, {6, 1}, {3, 2}, {0, 2}, {2, 4}, {4, 5}, {3, 5}}) {
    this->edge({0, base}, {0, target}, ++mark);
  }
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_THAT(log->poses,
              ElementsAre(PoseId{0, 0}, PoseId{0, 1}, PoseId{0, 3}, PoseId{0, 2}, PoseId{0, 4}, PoseId{0, 5}, PoseId{0, 6}));
  EXPECT_THAT(marks(log->odometry()), ElementsAre(1, 2, 4, 6, 7));
  EXPECT_THAT(marks(log->closures()), ElementsAre(3, 5, 8));
  LogBuilder<TestFixture::kDim> again("again.log");
  again.append(*log);
  EXPECT_EQ(std::move(again).finish()->poses, log->poses);
}

TYPED_TEST(DrivingOrderTest, ALogThatIsReadAgainHasTheSameOrder) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::mt19937 random(seed);
    for (const auto& [base, target] : swapped_drive(random)) this->edge({0, base}, {0, target});
    const auto log = this->finish().value();
    this->builder = LogBuilder<TestFixture::kDim>("again.log");
    this->builder.append(log);
    ASSERT_EQ(this->finish()->poses, log.poses) << seed;
    this->builder = LogBuilder<TestFixture::kDim>("some.log");
  }
}

TYPED_TEST(DrivingOrderTest, IdsTellTheOrderOfPosesThatSeeNewMarkers) {
  for (const auto& [base, target] :
       std::vector<std::pair<std::uint64_t, std::uint64_t>>{{0, 1}, {1, 100}, {1, 2}, {2, 101}, {2, 3}, {3, 102}}) {
    this->edge({0, base}, {0, target});
  }
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_TRUE(std::is_sorted(log->poses.begin(), log->poses.end()));
}

TYPED_TEST(DrivingOrderTest, EdgesTellTheOrderOfSessionsThatAreMixed) {
  // Two sessions, both driven as 0, 1, 2, 4, 3, 5.
  for (const auto& [base, target] :
       std::vector<std::pair<std::uint64_t, std::uint64_t>>{{0, 1}, {1, 2}, {2, 4}, {4, 3}, {3, 5}}) {
    for (const std::uint32_t session : {1u, 0u}) this->edge({session, base}, {session, target});
  }
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_EQ(log->poses[3], (PoseId{0, 4}));
  EXPECT_EQ(log->poses[9], (PoseId{1, 4}));
  EXPECT_EQ(log->sessions.size(), 2u);
}

TYPED_TEST(DrivingOrderTest, EdgesTellNoOrderWhereTheyAreNotChains) {
  for (const std::uint64_t leaf : {0u, 1u, 2u, 3u, 5u, 6u, 7u, 8u}) this->edge({0, 4}, {0, leaf});
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_TRUE(std::is_sorted(log->poses.begin(), log->poses.end()));
}

TYPED_TEST(DrivingOrderTest, ChainsStayWithinTheUsersSessions) {
  for (const std::uint32_t session : {1u, 0u}) {
    this->edge({session, 3}, {session, 0});
    this->edge({session, 0}, {session, 2});
    this->edge({session, 2}, {session, 4});
    this->edge({session, 4}, {session, 1});
  }
  this->edge({0, 1}, {1, 3});
  const auto log = this->finish();
  ASSERT_TRUE(log);
  EXPECT_THAT(log->poses, ElementsAre(PoseId{0, 3}, PoseId{0, 0}, PoseId{0, 2}, PoseId{0, 4}, PoseId{0, 1}, PoseId{1, 3},
                                      PoseId{1, 0}, PoseId{1, 2}, PoseId{1, 4}, PoseId{1, 1}));
  EXPECT_EQ(log->sessions.size(), 2u);
  EXPECT_EQ(log->closures().size(), 1u);
}

}  // namespace
}  // namespace mapjoin
