// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <apps/report/associations.hpp>

namespace mapjoin::apps {
namespace {

TEST(AssociationsTable, NamesAreThoseOfOtherTables) {
  const Options options;
  RunReport run_report("run", options);
  const std::uint64_t x7 = parse_key("x7").value();
  const std::uint64_t l3 = parse_key("l3").value();
  run_report.associations = {{.base = {0, x7}, .name = {l3}, .joined = {5}, .distance = {}}};
  EXPECT_TRUE(associations_as_csv(run_report).ends_with("\nx7,l3,5,,0,0,0\n")) << associations_as_csv(run_report);
}

}  // namespace
}  // namespace mapjoin::apps
