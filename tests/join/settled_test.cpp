// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <map>
#include <mapjoin/join/settled.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// What a way found, or that it met something singular.
struct Found {
  MinimiseResult result;
  double largest_rotation = 0.0;
  bool is_settled = false;
  Schedule way = Schedule::kAuto;
};

/// A solve that converged at this chi2, so many steps of which gained less than promised, and turned a pose so far.
Found found(double chi2, int short_steps, double largest_rotation) {
  Found found;
  found.result.status = MinimiseStatus::kConverged;
  found.result.chi2 = chi2;
  found.result.short_steps = short_steps;
  found.largest_rotation = largest_rotation;
  return found;
}

/// Finds by each way what is given for it; bad input where nothing is.
class Ways {
 public:
  explicit Ways(std::map<Schedule, Found> found) : found_(std::move(found)) {}

  Expected<Found> best() {
    return best_of_ways<Found>(
        [&](Schedule way) -> Expected<Found> {
          tried.push_back(way);
          const auto known = found_.find(way);
          if (known == found_.end()) return bad_input("singular");
          Found found = known->second;
          found.way = way;
          return found;
        },
        [](Found& found) {
          return SolveByWay{found.result, found.largest_rotation, found.is_settled};
        });
  }

  std::vector<Schedule> tried;

 private:
  std::map<Schedule, Found> found_;
};

using ::testing::ElementsAre;
constexpr Schedule kAligned = Schedule::kAligned;
constexpr Schedule kTree = Schedule::kTree;
constexpr Schedule kUnbalanced = Schedule::kUnbalanced;

TEST(BestOfWays, TakesTheFirstThatBeganNearItsOptimum) {
  Ways ways({{kAligned, found(9.0, 1, 0.5)}});
  EXPECT_TRUE(ways.best()->is_settled);
  EXPECT_THAT(ways.tried, ElementsAre(kAligned));
}

TEST(BestOfWays, TakesALaterOneOnlyWhereItWasAsGoodAsLinear) {
  Ways near({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(8.0, 1, 0.5)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(near.best()->way, kUnbalanced);
  Ways linear({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(8.0, 0, 2.0)}});
  EXPECT_EQ(linear.best()->way, kTree);
  EXPECT_THAT(linear.tried, ElementsAre(kAligned, kTree));
}

TEST(BestOfWays, BelievesAnOptimumThatTwoEndAtWhereOneOfThemCameFromNearBy) {
  Ways near({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(9.0, 1, 0.5)}});
  EXPECT_EQ(near.best()->way, kAligned);
  EXPECT_THAT(near.tried, ElementsAre(kAligned, kTree));
  Ways far({{kAligned, found(9.0, 1, 2.0)}, {kTree, found(9.0, 1, 2.0)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(far.best()->way, kUnbalanced);
}

TEST(BestOfWays, GoesOnWhereTheFirstOrALaterOneIsSingular) {
  Ways first({{kTree, found(9.0, 0, 0.5)}});
  EXPECT_EQ(first.best()->way, kTree);
  Ways later({{kAligned, found(9.0, 1, 2.0)}, {kUnbalanced, found(7.0, 1, 2.0)}});
  EXPECT_EQ(later.best()->way, kUnbalanced);
  Ways none({});
  EXPECT_FALSE(none.best().has_value());
  EXPECT_THAT(none.tried, ElementsAre(kAligned, kTree));
}

TEST(BestOfWays, EndsAtOtherErrors) {
  int calls = 0;
  const auto interrupted = best_of_ways<Found>(
      [&](Schedule) -> Expected<Found> {
        ++calls;
        return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
      },
      [](Found& found) {
        return SolveByWay{found.result, found.largest_rotation, found.is_settled};
      });
  EXPECT_EQ(interrupted.error().kind, ErrorKind::kInterrupted);
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace mapjoin
