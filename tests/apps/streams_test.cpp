// SPDX-License-Identifier: BSD-3-Clause
// Outputs that go to devices, pipes and standard output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Streams : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  TemporaryFolder folder;
};

TEST_F(Streams, NothingLiesBesideOne) {
  ProcessOptions here;
  here.standard_output = path("map.g2o");
  for (const std::string command : {"run", "solve"}) {
    const Ended nowhere = call({command, kBundledLog, "-o", "/dev/null", "--covariances", "--relations", "--report", "-"});
    EXPECT_EQ(nowhere.exit_code, 0);
    EXPECT_EQ(nowhere.err,
              "mapjoin: /dev/null: is no file beside which others could lie: covariances.json and relations.csv not written\n");
    EXPECT_THAT(nowhere.out, HasSubstr("median_deviation"));
    const Ended ended = call({command, kBundledLog, "-o", "/dev/stdout", "--robust"}, here);
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(ended.err, "mapjoin: /dev/stdout: is no file beside which others could lie: rejected.csv not written\n");
    EXPECT_THAT(content_of(path("map.g2o")), StartsWith("# "));
  }
  EXPECT_FALSE(fs::exists("/dev/stdout.rejected.csv") || fs::exists("/dev/null.covariances.json"));
}

TEST_F(Streams, StandardOutputHasOneOutputAtMost) {
  expect_failure(call({"run", kBundledLog, "-o", "/dev/stdout", "--report", "-"}), 2,
                 "--output and --report cannot both go to standard output");
  expect_failure(call({"run", kBundledLog, "--follow", "--idle", "0", "-o", "/dev/stdout", "--steps", "-"}), 2,
                 "--output and --steps cannot both go to standard output");
  expect_failure(call({"simulate", "-o", "/dev/stdout", "--truth", "/dev/stdout"}), 2,
                 "--output and --truth cannot both go to standard output");
  ProcessOptions nowhere;
  nowhere.standard_output = "/dev/null";
  EXPECT_EQ(call({"run", kBundledLog, "-o", "/dev/stdout", "--report", "-"}, nowhere).exit_code, 0);
}

TEST_F(Streams, AMapGoesThroughAPipeToo) {
  const std::string run = kCommand + " solve " + kBundledLog + " --quiet -o /dev/stdout | cat > " + path("piped.g2o");
  Process process({"sh", "-c", run});
  ASSERT_EQ(process.wait(), 0) << process.standard_error();
  ASSERT_EQ(call({"solve", kBundledLog, "-o", path("map.g2o")}).exit_code, 0);
  EXPECT_EQ(content_of(path("piped.g2o")), content_of(path("map.g2o")));
}

TEST_F(Streams, ARunOnStandardOutputIsTheMap) {
  const Ended run = call({"run", kBundledLog, "-o", "/dev/stdout"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("map.g2o")}).exit_code, 0);
  EXPECT_EQ(run.out, content_of(path("map.g2o")));
  Process piped({"sh", "-c", kCommand + " run " + kBundledLog + " -o /dev/stdout | cat > " + path("piped.g2o")});
  ASSERT_EQ(piped.wait(), 0) << piped.standard_error();
  EXPECT_EQ(content_of(path("piped.g2o")), run.out);
}

TEST_F(Streams, AMapGoesOnBehindWhatStandardOutputHasInIt) {
  const auto log = folder.file("log.txt", "before\n");
  Process process({"sh", "-c", kCommand + " solve " + kBundledLog + " --quiet -o /dev/stdout >> " + log.string()});
  ASSERT_EQ(process.wait(), 0) << process.standard_error();
  EXPECT_EQ(content_of(log).substr(0, 9), "before\n# ");
}

TEST_F(Streams, AnOutputOnStandardOutputHasNoSummaryBesideIt) {
  const std::string log = folder.file("log.g2o", kSmallLog).string();
  for (std::vector<std::string> words :
       std::vector<std::vector<std::string>>{{"solve", log, "-o", "/dev/stdout"},
                                             {"convert", log, "/dev/stdout", "--to", "isam"},
                                             {"simulate", "--poses", "30", "-o", "/dev/stdout"},
                                             {"check", log, "-o", "/dev/stdout"},
                                             {"covariance", log, "1", "-o", "/dev/stdout"}}) {
    const std::string out = call(words).out;
    EXPECT_FALSE(out.empty()) << words.front();
    words.emplace_back("--quiet");
    EXPECT_EQ(out, call(words).out) << words.front();
  }
  EXPECT_TRUE(nlohmann::json::accept(call({"run", log, "--report", "/dev/stdout"}).out));
  Process piped({"sh", "-c", kCommand + " convert " + log + " /dev/stdout --to isam | " + kCommand + " run /dev/stdin"});
  EXPECT_EQ(piped.wait(), 0) << piped.standard_error();
}

TEST_F(Streams, NoFileTakesThePlaceOfAClosedOne) {
  const auto with = [&](const std::string& words) { return Process({"sh", "-c", kCommand + " " + words}).wait(); };
  const std::string run = "run " + kBundledLog + " -o " + path("out");
  EXPECT_EQ(with(run + " >&-"), 5) << "the summary";
  EXPECT_EQ(with(run + " --quiet >&- 2>&- <&-"), 0);
  EXPECT_EQ(with("--help >&-"), 5);
  fs::create_symlink("/proc/self/fd/1", path("stdout"));
  EXPECT_EQ(with("solve " + kBundledLog + " --quiet -o " + path("stdout") + " >&-"), 5) << "by its path";
  EXPECT_EQ(with("solve " + kBundledLog + " --quiet -o " + path("a.g2o") + " --report /dev/null >&-"), 0) << "another file";
}

TEST_F(Streams, ASentenceOnATerminalHasALineOfItsOwn) {
  if (std::system("command -v script > /dev/null") != 0) GTEST_SKIP() << "needs script, which is not installed";
  const std::string run = "run " + folder.file("log.g2o", kSmallLog).string() + " --covariances -o " + path("out");
  Process process({"script", "-qec", kCommand + " " + run, "/dev/null"});
  ASSERT_EQ(process.wait(), 0);
  EXPECT_THAT(process.standard_output(), HasSubstr("\nmapjoin: map.svg: "));
}

TEST_F(Streams, AReaderThatHasGoneIsNoError) {
  ProcessOptions gone;
  gone.reader_has_gone = true;
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"run", kBundledLog}, {"info", kBundledLog}, {"--help"}}) {
    const Ended ended = call(arguments, gone);
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(ended.err, "");
  }
}

}  // namespace
}  // namespace mapjoin::testing
