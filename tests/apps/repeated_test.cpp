// SPDX-License-Identifier: BSD-3-Clause
// Repeated calls give the same bytes, on any number of threads. MAPJOIN_REPEATS says how many calls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <iostream>
#include <tests/apps/writing_calls.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// A report without times and memory.
nlohmann::json without_times(const nlohmann::json& report) {
  if (!report.is_structured()) return report;
  nlohmann::json kept = report;
  if (kept.is_object()) {
    kept.erase("seconds");
    kept.erase("peak_memory_mb");
  }
  for (auto& value : kept) value = without_times(value);
  return kept;
}

class Repeated : public ::testing::Test {
 protected:
  /// The files that a call writes into the folder, and its report.
  Files written_by(Words words, const std::string& jobs) const {
    fs::remove_all(out);
    fs::create_directory(out);
    const std::string report = out + "/times.json";
    words.insert(words.end(), {"--quiet", "--jobs", jobs, "--report", report});
    const Ended ended = call(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    Files files = files_in(out);
    files["times.json"] = without_times(nlohmann::json::parse(content_of(report))).dump();
    return files;
  }
  void expect_same_bytes(const Words& simulated) const {
    Words simulate = {"simulate", "-o", log, "--quiet"};
    simulate.insert(simulate.end(), simulated.begin(), simulated.end());
    ASSERT_EQ(call(simulate).exit_code, 0);
    ASSERT_EQ(call({"build", log, "-o", store, "--quiet"}).exit_code, 0);
    const std::vector<Words> calls = {{"run", log, "--covariances", "--relations", "-o", out + "/run"},
                                      {"build", log, "-o", out + "/maps"},
                                      {"join", store, "--covariances", "--relations", "-o", out + "/map.csv"},
                                      {"solve", log, "--state", "relative", "-o", out + "/map.g2o"},
                                      {"solve", log, "--schedule", "batch", "--covariances", "-o", out + "/map.g2o"}};
    const std::array<std::string, 4> jobs = {"1", "2", "4", "8"};
    int same = 0;
    for (const Words& words : calls) {
      const Files first = written_by(words, "1");
      ASSERT_GE(first.size(), 2u);
      for (int k = 1; k < repeats; ++k) {
        const std::string& threads = jobs[static_cast<std::size_t>(k) % jobs.size()];
        const bool is_same = written_by(words, threads) == first;
        EXPECT_TRUE(is_same) << ::testing::PrintToString(words) << " on " << threads << " threads";
        same += is_same ? 1 : 0;
      }
    }
    std::cout << fmt::format("{} of {} calls wrote what the first on one thread did\n", same,
                             (repeats - 1) * static_cast<int>(calls.size()));
  }

  TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::string store = (folder.path() / "store").string();
  const std::string out = (folder.path() / "out").string();
  const int repeats = how_often("MAPJOIN_REPEATS", 4);
};

TEST_F(Repeated, CallsInThePlaneWriteTheSameBytes) {
  expect_same_bytes({"--poses", "400"});
}

TEST_F(Repeated, CallsInSpaceWriteTheSameBytes) {
  expect_same_bytes({"--dim", "3", "--poses", "300"});
}

TEST_F(Repeated, CallsWhoseFactorisationIsSharedOutWriteTheSameBytes) {
  expect_same_bytes({"--poses", "1500"});
}

}  // namespace
}  // namespace mapjoin::testing
