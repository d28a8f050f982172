// SPDX-License-Identifier: BSD-3-Clause
// Optima of public data sets, found by readers and reference optimiser alone, to compare the library's own optima with.
#include <gtest/gtest.h>

#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {
namespace {

TEST(CeresReferenceData, FindsTheOptimumOfTheCorrectedDlrLog) {
  const auto opened = open_log(data_file("dlr/dlr_corrected.g2o.gz"));
  ASSERT_TRUE(opened) << opened.error().message;
  const auto& log = std::get<Log<2>>(*opened);
  EXPECT_EQ(degrees_of_freedom(log, 1), 27270);
  const auto result = ceres_optimum(log, odometry_start(log));
  EXPECT_NEAR(result.chi2, 27688.555566, 1e-4);
  const Chi2 chi2 = log_chi2(log, result.values);
  EXPECT_NEAR(chi2.total(), result.chi2, 1e-8 * result.chi2);
  EXPECT_NEAR(chi2.odometry, 8129.42, 0.01);
  EXPECT_NEAR(chi2.observations, 19559.13, 0.01);
}

TEST(CeresReferenceData, FindsTheOptimumOfVictoriaParksLocalMaps) {
  const auto read = read_local_map_set(data_file("vicpark-200-local-maps"));
  ASSERT_TRUE(read) << read.error().message;
  const auto& set = std::get<SubmapSet<2>>(*read);
  const auto result = ceres_optimum(set, composed_start(set));
  EXPECT_NEAR(result.initial_chi2, 13859095.8, 0.1);
  EXPECT_NEAR(result.chi2, 3643.43494, 1e-4);
}

}  // namespace
}  // namespace mapjoin::testing
