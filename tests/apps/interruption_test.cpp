// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <apps/process.hpp>
#include <array>
#include <chrono>
#include <iostream>
#include <tests/apps/command.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;

/// Ignores the request to stop. This process sends itself `first`, `second` at once, which may count as the same request, and
/// `second` again.
[[noreturn]] void go_on_whatever_is_asked(int first, int second) {
  ::alarm(60);
  apps::keep_blas_on_one_thread();
  const apps::Interruption interruption;
  ::kill(::getpid(), first);
  while (!interruption.token().stop_requested()) std::this_thread::yield();
  ::kill(::getpid(), second);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::cerr << "both at once were one request";
  ::kill(::getpid(), second);
  while (true) ::pause();
}

TEST(InterruptionDeathTest, TheSecondSignalEndsTheProcessWhateverItDoes) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(go_on_whatever_is_asked(SIGTERM, SIGTERM), ::testing::ExitedWithCode(130), "were one request");
  EXPECT_EXIT(go_on_whatever_is_asked(SIGINT, SIGTERM), ::testing::ExitedWithCode(130), "were one request");
}

/// Calls that are sent a signal as soon as they have begun to write at `sign`.
class InterruptedCall : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  void SetUp() override { ASSERT_EQ(call({"simulate", "--poses", "30000", "-o", path("log.g2o"), "--quiet"}).exit_code, 0); }
  Ended interrupted(const std::vector<std::string>& arguments, const fs::path& sign, int signal) {
    Process process(command_line(arguments));
    while (process.is_running() && !fs::exists(sign)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    process.send(signal);
    const int exit_code = process.wait();
    return {exit_code, process.standard_output(), process.standard_error()};
  }
  TemporaryFolder folder;
};

TEST_F(InterruptedCall, LeavesNothingOfARun) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Ended ended = interrupted({"run", path("log.g2o"), "-o", path("out")}, path("out"), signal);
    EXPECT_EQ(ended.exit_code, 130);
    EXPECT_EQ(ended.err, "mapjoin: interrupted\n");
    EXPECT_EQ(ended.out, "");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"log.g2o"});
  }
}

TEST_F(InterruptedCall, ABuildGoesOnAndEndsWithTheSameBytes) {
  const std::vector<std::string> build = {"build", path("log.g2o"), "-o", path("maps"), "--quiet"};
  const Ended ended = interrupted(build, path("maps.partial"), SIGINT);
  EXPECT_EQ(ended.exit_code, 130);
  EXPECT_FALSE(fs::exists(path("maps")));
  ASSERT_EQ(call(build).exit_code, 0);
  ASSERT_EQ(call({"build", path("log.g2o"), "-o", path("whole"), "--quiet"}).exit_code, 0);
  EXPECT_EQ(content_of(path("maps")), content_of(path("whole")));
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"log.g2o", "maps", "whole"}));
}

/// What there is to read until its end.
std::string all_of(int descriptor) {
  std::string text;
  std::array<char, 4096> bytes;
  for (::ssize_t count; (count = ::read(descriptor, bytes.data(), bytes.size())) > 0;) {
    text.append(bytes.data(), static_cast<std::size_t>(count));
  }
  return text;
}

TEST_F(InterruptedCall, OfAFollowedLogASlowReaderGetsTheWholeMap) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("whole.g2o"), "--quiet"}).exit_code, 0);
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  Process process(
      command_line({"run", kBundledLog, "--follow", "--idle", "600", "--steps", path("steps"), "-o", path("pipe")}));
  while (process.is_running() && !fs::exists(path("steps"))) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  process.send(SIGINT);
  ::pollfd written{reader, POLLIN, 0};
  while (process.is_running() && ::poll(&written, 1, 100) == 0) continue;
  std::this_thread::sleep_for(std::chrono::seconds(2));  // until the pipe is full
  ::fcntl(reader, F_SETFL, 0);
  const std::string map = all_of(reader);
  ::close(reader);
  EXPECT_EQ(process.wait(), 0) << process.standard_error();
  EXPECT_TRUE(map == content_of(path("whole.g2o"))) << map.size();
}

TEST_F(InterruptedCall, EndsACallThatWaitsForAPipe) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const auto interrupted_soon = [&](const std::vector<std::string>& arguments) {
    Process process(command_line(arguments));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    process.send(SIGTERM);
    for (int k = 0; k < 1000 && process.is_running(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return !process.is_running() && process.wait() == 130;
  };
  EXPECT_TRUE(interrupted_soon({"info", path("pipe")})) << "while nobody writes";
  const int both_ends = ::open(path("pipe").c_str(), O_RDWR | O_CLOEXEC);
  EXPECT_TRUE(interrupted_soon({"info", path("pipe")})) << "while nothing comes";
  EXPECT_TRUE(interrupted_soon({"simulate", "-o", path("pipe")})) << "while nobody reads on";
  ::close(both_ends);
}

}  // namespace
}  // namespace mapjoin::testing
