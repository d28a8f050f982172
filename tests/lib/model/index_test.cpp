// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <mapjoin/model/index.hpp>
#include <string>
#include <type_traits>

namespace mapjoin {
namespace {

using Apple = StrongIndex<struct AppleTag>;
using Pear = StrongIndex<struct PearTag>;

template <typename Left, typename Right>
concept AreComparable = requires(Left left, Right right) {
  left == right;
};
template <typename Table, typename Index>
concept IsOpenedBy = requires(Table table, Index index) {
  table[index];
};

TEST(StrongIndex, IsNoIndexOfAnotherKind) {
  EXPECT_FALSE((std::is_constructible_v<Apple, Pear>));
  EXPECT_FALSE((std::is_assignable_v<Apple&, Pear>));
  EXPECT_FALSE((AreComparable<Apple, Pear>));
  EXPECT_TRUE((AreComparable<Apple, Apple>));
}

TEST(StrongIndex, BecomesAnIntegerByNameAlone) {
  EXPECT_FALSE((std::is_convertible_v<Apple, int>));
  EXPECT_FALSE((std::is_constructible_v<int, Apple>));
  EXPECT_EQ(Apple(7).value, 7);
  EXPECT_EQ(Apple(7).position(), std::size_t{7});
}

TEST(StrongIndex, CostsWhatItsIntegerCosts) {
  EXPECT_TRUE(std::is_trivially_copyable_v<Apple>);
  EXPECT_EQ(sizeof(Apple), sizeof(std::int32_t));
}

TEST(StrongIndex, IsMadeOfAConstantOrByName) {
  const Apple constant = 3;
  const std::size_t number = 3;
  EXPECT_EQ(constant, Apple(number));
  EXPECT_TRUE(Apple(number) == 3);
  EXPECT_TRUE(Apple() == 0);
}

TEST(StrongIndex, StepsAndComparesAsItsInteger) {
  Apple apple = 4;
  EXPECT_LT(apple - 1, apple);
  EXPECT_EQ(apple + 2, Apple(6));
  EXPECT_EQ(Apple(9) - apple, 5);
  EXPECT_EQ(++apple, Apple(5));
  EXPECT_EQ(--apple, Apple(4));
}

TEST(IndexRange, HasEveryIndexButTheLastInOrder) {
  const IndexRange<Apple> range{2, 5};
  EXPECT_EQ(std::vector<Apple>(range.begin(), range.end()), (std::vector<Apple>{2, 3, 4}));
  EXPECT_EQ(range.size(), 3U);
  EXPECT_TRUE(range.contains(2));
  EXPECT_TRUE(range.contains(4));
  EXPECT_FALSE(range.contains(5));
  EXPECT_FALSE(range.contains(1));
}

TEST(Table, IsOpenedByItsOwnKindAlone) {
  using Names = Table<Apple, std::string>;
  EXPECT_TRUE((IsOpenedBy<Names, Apple>));
  EXPECT_FALSE((IsOpenedBy<Names, Pear>));
  EXPECT_FALSE((IsOpenedBy<const Names, Pear>));
}

TEST(Table, HasAnEntryForEachOfItsIndices) {
  Table<Apple, std::string> names{"boskoop", "elstar"};
  names[1] = "topaz";
  std::vector<std::string> seen;
  for (const Apple apple : indices(names)) seen.push_back(names[apple]);
  EXPECT_EQ(seen, (std::vector<std::string>{"boskoop", "topaz"}));
  EXPECT_TRUE(std::ranges::equal(seen, names));
}

TEST(Table, OfBoolsCanBeWritten) {
  Table<Apple, bool> is_ripe(2, false);
  is_ripe[1] = true;
  EXPECT_FALSE(is_ripe[0]);
  EXPECT_TRUE(is_ripe[1]);
}

TEST(Lists, HaveOneListForEachIndex) {
  Lists<Apple, int> seeds;
  seeds.push_back(std::vector{3, 4});
  seeds.push_back(std::vector<int>());
  Lists<Apple, int> more;
  more.push_back(std::vector{5});
  seeds.append(more);
  ASSERT_EQ(seeds.size(), 3U);
  EXPECT_TRUE(std::ranges::equal(seeds[0], std::vector{3, 4}));
  EXPECT_TRUE(seeds[1].empty());
  EXPECT_TRUE(std::ranges::equal(seeds[2], std::vector{5}));
  EXPECT_EQ(seeds.entries(), (std::vector{3, 4, 5}));
  EXPECT_EQ(seeds.first(2), 2U);
  EXPECT_FALSE((IsOpenedBy<decltype(seeds), Pear>));
}

}  // namespace
}  // namespace mapjoin
