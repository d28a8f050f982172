// SPDX-License-Identifier: BSD-3-Clause
// Several processes that write the same outputs at once, and inputs that change while they are read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <tests/apps/writing_calls.hpp>
#include <tests/support/random.hpp>
#include <thread>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class AtOnce : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(call({"simulate", "--poses", "1000", "-o", log, "--quiet"}).exit_code, 0);
    ASSERT_EQ(call({"build", log, "-o", store, "--poses-per-map", "20", "--quiet"}).exit_code, 0);
  }
  void empty() const {
    fs::remove_all(out);
    fs::create_directory(out);
  }
  TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::string store = (folder.path() / "store").string();
  const std::string out = (folder.path() / "out").string();
};

TEST_F(AtOnce, OneWritesAndTheOthersSayThatItDoes) {
  std::vector<WritingCall> calls = writing_calls(log, store);
  calls.push_back(writing_call({"build", log, "--poses-per-map", "2", "-o"}, "maps"));
  for (const WritingCall& writing : calls) {
    SCOPED_TRACE(::testing::PrintToString(writing.words(out)));
    empty();
    ASSERT_EQ(call(writing.words(out)).exit_code, 0);
    const Files expected = files_in(out);
    empty();
    std::vector<std::unique_ptr<Process>> processes;
    for (int k = 0; k < 4; ++k) processes.push_back(std::make_unique<Process>(command_line(writing.words(out))));
    int done = 0;
    for (const auto& process : processes) {
      if (process->wait() == 0) {
        ++done;
        continue;
      }
      EXPECT_EQ(process->wait(), 5);
      EXPECT_THAT(process->standard_error(), AnyOf(HasSubstr("another process is writing it"), HasSubstr("not empty")));
    }
    EXPECT_GT(done, 0);
    EXPECT_TRUE(files_in(out) == expected);
  }
}

/// An input that changes while it is read, at random moments.
TEST_F(AtOnce, AnInputThatIsReplacedOrCutShortIsReadOrRefused) {
  const std::string content = content_of(log);
  const std::string input = (folder.path() / "input.g2o").string();
  Random random;
  for (int k = 0; k < 12; ++k) {
    folder.file("input.g2o", content);
    Process process(command_line({"solve", input, "-o", out, "--quiet"}));
    std::this_thread::sleep_for(std::chrono::duration<double>(random.uniform(0.0, 0.06)));
    if (k % 2 == 0) {
      fs::resize_file(input, content.size() / 3);
    } else {
      fs::rename(folder.file("other.g2o", kSmallLog), input);
    }
    EXPECT_THAT(process.wait(), AnyOf(0, 3)) << process.standard_error();
  }
}

}  // namespace
}  // namespace mapjoin::testing
