// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tests/apps/command.hpp>
#include <tests/support/process.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The command on two processors at most, with a limit on its data or its address space.
class UnderALimit : public ::testing::TestWithParam<std::size_t ProcessOptions::*> {
 protected:
  void SetUp() override {
#ifdef MAPJOIN_SANITIZE
    GTEST_SKIP() << "Sanitizers need memory of their own.";
#endif
  }
  /// Calls the command with so much memory and a minute of CPU: without a buffer the BLAS would spin for ever.
  static Ended call(std::vector<std::string> words, std::size_t kilobytes) {
    ProcessOptions options;
    options.*GetParam() = kilobytes << 10;
    options.cpu_seconds = 60;
    words = command_line(std::move(words));
    words.insert(words.begin(), {"taskset", "--cpu-list", "0,1"});
    Process process(words, options);
    const int exit_code = process.wait();
    return {exit_code, process.standard_output(), process.standard_error()};
  }
  static void expect_refusal(const Ended& ended, const std::string& words) {
    EXPECT_EQ(ended.exit_code, 6) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(words));
    // The one sentence of the command comes last; METIS may have told before what memory it lacked.
    EXPECT_EQ(ended.err.rfind("mapjoin: "), ended.err.find("mapjoin: ")) << ended.err;
    EXPECT_EQ(ended.err.find('\n', ended.err.rfind("mapjoin: ")), ended.err.size() - 1) << ended.err;
  }
  /// The memory that the command says it needs to begin with (kB); 0 if it says none.
  static std::size_t needed() {
    constexpr std::size_t kTooLittle = 140000;
    const Ended refused = call({"--version"}, kTooLittle);
    expect_refusal(refused, "is limited to 140000 kB, and ");
    const std::string remedy = GetParam() == &ProcessOptions::memory_bytes ? "ulimit -d " : "ulimit -v ";
    const auto found = refused.err.find(remedy);
    return found == std::string::npos ? 0 : std::stoul(refused.err.substr(found + remedy.size()));
  }

  const TemporaryFolder folder;
};

TEST_P(UnderALimit, ThatIsTooLowForTheThreadsTheCommandSaysWhatWillDo) {
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::size_t enough = needed();
  constexpr std::size_t kFewPages = 256;  // kB by which two processes differ, for their libraries and stacks lie elsewhere
  expect_refusal(call({"run", log.string()}, enough - kFewPages), "kB are needed to begin with");
  const Ended ended = call({"run", log.string(), "--jobs", "2"}, enough + kFewPages);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
}

TEST_P(UnderALimit, ThatIsTooLowForTheWorkTheCommandSaysSoAndLeavesNothing) {
  const std::string log = (folder.path() / "log.g2o").string();
  const std::string map = (folder.path() / "map").string();
  const std::size_t enough = needed();
  ASSERT_EQ(testing::call({"simulate", "--poses", "200000", "-o", log, "--quiet"}).exit_code, 0);
  expect_refusal(call({"run", log, "-o", map, "--quiet"}, enough), "there is not enough memory for this");
  expect_refusal(call({"simulate", "--poses", "10000000", "-o", map}, enough), "there is not enough memory for this");
  EXPECT_FALSE(fs::exists(map));
}

INSTANTIATE_TEST_SUITE_P(Size, UnderALimit,
                         ::testing::Values(&ProcessOptions::memory_bytes, &ProcessOptions::address_space_bytes),
                         [](const auto& limit) { return limit.index == 0 ? "OfData" : "OfAddressSpace"; });

/// The only threads while a log is followed are the main thread and the one that waits for signals.
TEST(Blas, HasNoThreadsOfItsOwnInTheCommand) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", "");
  Process process(command_line({"run", "--follow", log.string(), "--steps", (folder.path() / "steps").string()}));
  while (process.is_running() && !fs::exists(folder.path() / "steps")) std::this_thread::yield();
  EXPECT_EQ(threads_of(std::to_string(process.id())), 2);
}

}  // namespace
}  // namespace mapjoin::testing
