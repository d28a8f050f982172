// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <mapjoin/localmap/stored_build.hpp>
#include <set>

namespace mapjoin {
namespace {

TEST(BuildSettings, DifferWhereverMapsMay) {
  std::set<std::string> settings{build_settings({}),
                                 build_settings({.method = Method::kLevenbergMarquardt}),
                                 build_settings({.max_iterations = 5}),
                                 build_settings({.relative_chi2 = 1e-3}),
                                 build_settings({.step_metres = 1e-3}),
                                 build_settings({.step_radians = 1e-3}),
                                 build_settings({.damp_singular = true})};
  EXPECT_EQ(settings.size(), 7U);
  EXPECT_FALSE(settings.insert(build_settings({.engine = Engine::kCholmod})).second) << "maps are eliminated without an engine";
}

}  // namespace
}  // namespace mapjoin
