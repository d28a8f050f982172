// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Calls of `mapjoin-mpi` on several ranks, in a folder of their own.

#include <gtest/gtest.h>

#include <tests/apps/command.hpp>
#include <tests/mpi/mpi_command.hpp>
#include <tests/support/data.hpp>

namespace mapjoin::testing {

class RanksTest : public ::testing::Test {
 protected:
  static Ended call_ranks(int ranks, const std::vector<std::string>& arguments) {
    Process process(mpi_command_line(ranks, arguments));
    const int exit_code = process.wait();
    return {exit_code, process.standard_output(), process.standard_error()};
  }
  static nlohmann::json report_of_ranks(int ranks, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--report", "-"});
    const Ended ended = call_ranks(ranks, arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return nlohmann::json::parse(ended.out);
  }
  std::string bundled(const std::string& name) const { return (kBundledData / name).string(); }
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }

  TemporaryFolder folder;
};

}  // namespace mapjoin::testing
