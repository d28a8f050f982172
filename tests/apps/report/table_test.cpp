// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/report/table.hpp>

namespace mapjoin::apps {
namespace {

Table fruit() {
  return {{{"fruit", "fruit"}, {"price_eur", "price per piece", 3}, {"count", "count"}},
          {{{std::string("an apple"), 0.123456, std::int64_t{7}}}, {{std::string("fig, \"ripe\""), 12.0, {}}}}};
}

TEST(Table, IsAlignedWithNumbersToTheRight) {
  EXPECT_EQ(aligned(fruit()),
            "             price\n"
            "               per\n"
            "fruit        piece  count\n"
            "an apple     0.123      7\n"
            "fig, \"ripe\"     12\n");
}

TEST(Table, IsCsvOfExactNumbers) {
  EXPECT_EQ(csv(fruit()),
            "fruit,price_eur,count\n"
            "an apple,0.123456,7\n"
            "\"fig, \"\"ripe\"\"\",12,\n");
}

TEST(Table, OfNoRowsHasItsHeadings) {
  EXPECT_EQ(aligned({{{"a", "one two"}, {"b", "three"}}, {}}), "one\ntwo  three\n");
  EXPECT_EQ(csv({{{"a", "one"}, {"b", "two"}}, {}}), "a,b\n");
}

TEST(Table, ShowsWhatIsEmptyAsNothing) {
  EXPECT_EQ(shown(Cell(), {"a", "a"}), "");
  EXPECT_EQ(shown(1234.5678, {"a", "a", 6}), "1234.57");
}

}  // namespace
}  // namespace mapjoin::apps
