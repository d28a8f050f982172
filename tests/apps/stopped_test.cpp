// SPDX-License-Identifier: BSD-3-Clause
// Calls that are killed or interrupted at any moment. MAPJOIN_KILLS says how often; the moments are the same every time, as
// shares of the time that an undisturbed call takes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <tests/apps/writing_calls.hpp>
#include <tests/support/random.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using Seconds = std::chrono::duration<double>;

constexpr double kBeyondTheEnd = 1.15;  ///< Latest moment over the time of an undisturbed call: some lie behind its end.
const std::string kOld = "what was there before\n";

bool is_temporary(const std::string& name) {
  return name.find(".mapjoin-tmp") != name.npos;
}

/// The files in a folder, without temporary ones.
Files outputs_in(const fs::path& folder) {
  Files files = files_in(folder);
  std::erase_if(files, [](const auto& file) { return is_temporary(file.first); });
  return files;
}

class Stopped : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(call({"simulate", "--poses", "1000", "--seed", "5", "-o", log, "--quiet"}).exit_code, 0);
    ASSERT_EQ(call({"build", log, "-o", maps, "--poses-per-map", "20", "--quiet"}).exit_code, 0);
  }
  void empty() const {
    fs::remove_all(out);
    fs::create_directory(out);
  }
  /// The time that a call takes undisturbed, the longer of two; its outputs are in the folder then.
  Seconds time_of(const WritingCall& writing) const {
    Seconds longest{0.0};
    for (int k = 0; k < 2; ++k) {
      empty();
      const auto begin = std::chrono::steady_clock::now();
      EXPECT_EQ(call(writing.words(out)).exit_code, 0);
      longest = std::max<Seconds>(longest, std::chrono::steady_clock::now() - begin);
    }
    return longest;
  }
  /// The end of a call that is sent the signal at a random moment.
  Ended stop(const WritingCall& writing, Seconds whole, int signal) {
    Process process(command_line(writing.words(out)));
    std::this_thread::sleep_for(random.uniform(0.0, kBeyondTheEnd) * whole);
    process.send(signal);
    const int exit_code = process.wait();
    return {exit_code, process.standard_output(), process.standard_error()};
  }
  /// Expects every output to be as it was before or as it is to be, and none to be gone.
  static void expect_whole(const Files& found, const Files& before, const Files& expected) {
    for (const auto& [name, content] : found) {
      const bool is_old = before.contains(name) && content == before.at(name);
      EXPECT_TRUE(is_old || (expected.contains(name) && content == expected.at(name))) << name;
    }
    for (const auto& [name, content] : before) EXPECT_TRUE(found.contains(name)) << name;
  }
  /// Stops each of the writing_calls() `times` times; `check` takes its end, what it left, and what it would write undisturbed.
  void stop_all(int times, const std::vector<int>& signals,
                const std::function<void(const Ended&, const Files& found, const Files& expected)>& check);

  TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::string maps = (folder.path() / "store").string();
  const std::string out = (folder.path() / "out").string();
  Random random{7};
  const int kills = how_often("MAPJOIN_KILLS", 16);
};

void Stopped::stop_all(int times, const std::vector<int>& signals,
                       const std::function<void(const Ended&, const Files&, const Files&)>& check) {
  int before_the_end = 0;
  const std::vector<WritingCall> calls = writing_calls(log, maps);
  for (const WritingCall& writing : calls) {
    const Seconds whole = time_of(writing);
    const Files expected = outputs_in(out);
    SCOPED_TRACE(::testing::PrintToString(writing.words(out)));
    ASSERT_FALSE(expected.empty());
    for (int k = 0; k < times; ++k) {
      empty();
      Files before;
      for (const auto& [name, content] : expected) {
        if (!writing.replaces || k % 2 == 0) break;
        fs::create_directories(fs::path(out + "/" + name).parent_path());
        before[name] = content_of(folder.file("out/" + name, kOld));
      }
      const Ended ended = stop(writing, whole, signals[static_cast<std::size_t>(k) % signals.size()]);
      const Files found = outputs_in(out);
      if (found != expected) ++before_the_end;
      expect_whole(found, before, expected);
      EXPECT_TRUE(writing.replaces || found.empty() || found == expected);
      check(ended, found, expected);
      if (!writing.replaces && !found.empty()) continue;
      ASSERT_EQ(call(writing.words(out)).exit_code, 0);
      EXPECT_TRUE(files_in(out) == expected) << "something is left of the call that was stopped";
    }
  }
  const int all = times * static_cast<int>(calls.size());
  std::cout << fmt::format("{} of {} calls stopped before all of their outputs were there\n", before_the_end, all);
  EXPECT_GT(4 * before_the_end, all) << "most signals came too late to tell anything";
}

TEST_F(Stopped, ABuildThatIsKilledGoesOnFromAnyMomentToTheSameBytes) {
  const std::string long_log = (folder.path() / "long.g2o").string();
  ASSERT_EQ(call({"simulate", "--poses", "4000", "-o", long_log, "--quiet"}).exit_code, 0);
  const WritingCall build{[&](const std::string& where) {
    return std::vector<std::string>{"build",         long_log,   "--poses-per-map",     "2", "--quiet", "-o",
                                    where + "/maps", "--report", where + "/report.json"};
  }};
  const Seconds whole = time_of(build);
  const Files expected = files_in(out);
  std::map<std::string, int> stages;
  for (int k = 0; k < kills; ++k) {
    empty();
    stop(build, whole, SIGKILL);
    const bool is_done = fs::exists(out + "/maps");
    const bool is_begun = fs::exists(out + "/maps.partial");
    if (is_done) {
      EXPECT_TRUE(content_of(out + "/maps") == expected.at("maps")) << k;
    } else if (is_begun) {
      const Ended info = call({"info", out + "/maps.partial"});
      EXPECT_THAT(info.exit_code, AnyOf(0, 3)) << info.err;
      EXPECT_EQ(std::count(info.err.begin(), info.err.end(), '\n'), info.exit_code == 0 ? 0 : 1) << info.err;
    }
    ASSERT_EQ(call(build.words(out)).exit_code, 0) << k;
    EXPECT_TRUE(files_in(out) == expected) << k;
    const bool goes_on = nlohmann::json::parse(content_of(out + "/report.json")).at("local_maps").at("iterations").is_null();
    ++stages[is_done    ? "after the store was there"
             : goes_on  ? "with maps to go on from"
             : is_begun ? "before the first maps were safe"
                        : "before the store was begun"];
  }
  for (const auto& [stage, count] : stages) std::cout << fmt::format("{} of {} kills {}\n", count, kills, stage);
  EXPECT_GT(stages["with maps to go on from"], 0) << "no kill came in the middle";
}

TEST_F(Stopped, NoOutputOfACallThatIsKilledIsHalfWritten) {
  stop_all(std::max(2, kills / 8), {SIGKILL}, [](const Ended&, const Files&, const Files&) {});
}

TEST_F(Stopped, ACallThatIsInterruptedSaysSoAndLeavesNothingBehind) {
  stop_all(std::max(2, kills / 8), {SIGINT, SIGTERM}, [&](const Ended& ended, const Files& found, const Files& expected) {
    // The signal may come before the command can handle it.
    EXPECT_THAT(ended.exit_code, AnyOf(0, 130, 1000 + SIGINT, 1000 + SIGTERM));
    EXPECT_TRUE(ended.exit_code != 0 || found == expected);
    EXPECT_TRUE(ended.exit_code != 130 || ended.err == "mapjoin: interrupted\n") << ended.err;
    EXPECT_TRUE(ended.exit_code > 1000 || files_in(out) == found) << "something temporary is left";
  });
}

}  // namespace
}  // namespace mapjoin::testing
