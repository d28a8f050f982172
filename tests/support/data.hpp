// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Public data sets, which are not part of this project: a test that needs them is skipped if they are absent.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace mapjoin::testing {

/// The file or folder `relative` below the folder that the environment variable MAPJOIN_DATA_DIR names. If it is missing the
/// running test ends here: it is skipped, or fails if MAPJOIN_REQUIRE_DATA is set. To be called in the body of a test or in
/// SetUp().
inline std::filesystem::path data_file(const std::string& relative) {
  const char* folder = std::getenv("MAPJOIN_DATA_DIR");
  if (folder && std::filesystem::exists(std::filesystem::path(folder) / relative)) {
    return std::filesystem::path(folder) / relative;
  }
  const std::string reason = folder ? relative + " is not in " + folder + ", the folder that MAPJOIN_DATA_DIR names."
                                    : "Needs " + relative + " below the folder that MAPJOIN_DATA_DIR would name; it is unset.";
  const bool required = std::getenv("MAPJOIN_REQUIRE_DATA") != nullptr;
  [&] {
    if (required) FAIL() << reason;
    GTEST_SKIP() << reason;
  }();
  using Result = ::testing::TestPartResult;
  throw ::testing::AssertionException(
      Result(required ? Result::kFatalFailure : Result::kSkip, __FILE__, __LINE__, reason.c_str()));
}

}  // namespace mapjoin::testing
