// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/report/table.hpp>
#include <cmath>
#include <limits>

namespace mapjoin::apps {
namespace {

ReportTable fruit() {
  return {{{"fruit", "fruit"}, {"price_eur", "price per piece", 3}, {"count", "count"}},
          {{{"an apple", 0.123456, 7}}, {{"fig, \"ripe\"", 12.0, nullptr}}}};
}

TEST(ReportTable, IsAlignedWithNumbersToTheRight) {
  EXPECT_EQ(aligned(fruit()),
            "             price\n"
            "               per\n"
            "fruit        piece  count\n"
            "an apple     0.123      7\n"
            "fig, \"ripe\"     12\n");
}

TEST(ReportTable, IsCsvOfExactNumbers) {
  EXPECT_EQ(csv(fruit()),
            "fruit,price_eur,count\n"
            "an apple,0.123456,7\n"
            "\"fig, \"\"ripe\"\"\",12,\n");
}

TEST(ReportTable, OfNoRowsHasItsHeadings) {
  EXPECT_EQ(aligned({{{"a", "one two"}, {"b", "three"}}, {}}), "one\ntwo  three\n");
  EXPECT_EQ(csv({{{"a", "one"}, {"b", "two"}}, {}}), "a,b\n");
}

TEST(ReportTable, ShowsWhatIsEmptyAsNothing) {
  EXPECT_EQ(shown(Cell(), {"a", "a"}), "");
  EXPECT_EQ(shown(1234.5678, {"a", "a", 6}), "1234.57");
}

TEST(ReportTable, TakesItsCellsFromAnObject) {
  ReportTable table{{{"name", "name"}, {"mb", "memory (MB)", 3, "/effort/bytes", 1e-6}, {"none", "none"}}, {}};
  table.add({{"name", "tree"}, {"effort", {{"bytes", 2'500'000}}}});
  table.add({{"name", "batch"}, {"effort", {{"bytes", nullptr}}}});
  EXPECT_EQ(csv(table), "name,mb,none\ntree,2.5,\nbatch,,\n");
}

TEST(ReportTable, HasNothingForWhatIsNotFinite) {
  EXPECT_EQ(csv({{{"a", "a"}, {"b", "b"}}, {{{std::numeric_limits<double>::infinity(), std::nan("")}}}}), "a,b\n,\n");
}

}  // namespace
}  // namespace mapjoin::apps
