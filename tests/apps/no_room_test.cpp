// SPDX-License-Identifier: BSD-3-Clause
// Calls that cannot write their outputs: every file is then as it was, and one sentence says why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <tests/apps/writing_calls.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const std::string kOld = "what was there before\n";

/// True for the files of an unfinished store, which waits for its build to go on.
bool is_unfinished_store(const std::string& name) {
  return name.starts_with("maps.partial");
}

class NoRoom : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(call({"simulate", "--poses", "300", "-o", log, "--quiet"}).exit_code, 0);
    ASSERT_EQ(call({"simulate", "--poses", "40", "-o", short_log, "--quiet"}).exit_code, 0);
    ASSERT_EQ(call({"build", log, "-o", store, "--poses-per-map", "20", "--quiet"}).exit_code, 0);
    fs::permissions(folder.path(), fs::perms::all);
  }
  std::vector<WritingCall> calls() const {
    std::vector<WritingCall> all = writing_calls(log, store);
    all.push_back(writing_call({"build", log, "-o"}, "maps"));
    all.push_back(writing_call({"solve", log, "--report", out + "/report.json", "--relations", "-o"}, "map.g2o"));
    all.push_back(writing_call({"plot", log, "-o"}, "map.svg"));
    all.push_back(writing_call({"convert", store, "--to", "maps-mat"}, "maps", false));
    all.push_back(writing_call({"simulate", "--poses", "500", "--truth", out + "/truth.csv", "-o"}, "log.g2o"));
    all.push_back(writing_call({"check", log, "--report"}, "check.json"));
    all.push_back(writing_call({"compare", short_log, "-o"}, "compared"));
    all.push_back(writing_call({"basin", short_log, "--seeds", "2", "-o"}, "basin"));
    all.push_back(writing_call({"convexity", short_log, "-o"}, "convexity"));
    return all;
  }
  void empty() const {
    fs::remove_all(out);
    fs::create_directory(out);
    fs::permissions(out, fs::perms::all);
  }
  /// The files that an undisturbed call writes. If it replaces files, the folder then holds files of these names with other
  /// contents.
  Files expected_of(const WritingCall& writing) const {
    empty();
    EXPECT_EQ(call(writing.words(out)).exit_code, 0);
    Files expected = files_in(out);
    empty();
    for (const auto& [name, content] : expected) {
      if (!writing.replaces) break;
      fs::create_directories(fs::path(out + "/" + name).parent_path());
      folder.file("out/" + name, kOld);
    }
    return expected;
  }
  /// Runs a call through another program that confines it, and expects each file in the folder `found` to be whole, as before
  /// or as it should be, and one sentence on standard error if the call failed. Returns its exit code.
  int expect_whole(Words confined, const WritingCall& writing, const Files& expected, const std::string& found) const {
    const Words words = command_line(writing.words(out));
    confined.insert(confined.end(), words.begin(), words.end());
    Process process(confined);
    const int exit_code = process.wait();
    const Files files = files_in(found);
    for (const auto& [name, content] : files) {
      const bool is_whole = content == kOld || (expected.contains(name) && content == expected.at(name));
      EXPECT_TRUE(is_whole || is_unfinished_store(name)) << name;
    }
    EXPECT_THAT(exit_code, ::testing::AnyOf(0, 5)) << process.standard_error();
    EXPECT_TRUE(exit_code != 0 || files == expected);
    if (exit_code == 0) return exit_code;
    EXPECT_THAT(process.standard_error(), ::testing::MatchesRegex("mapjoin: [^\n]*: [^\n]*\n"));
    return exit_code;
  }

  TemporaryFolder folder;
  const std::string log = (folder.path() / "log.g2o").string();
  const std::string short_log = (folder.path() / "short.g2o").string();
  const std::string store = (folder.path() / "store").string();
  const std::string out = (folder.path() / "out").string();
};

TEST_F(NoRoom, AFileThatMayNotGrowIsNotWritten) {
  for (const WritingCall& writing : calls()) {
    SCOPED_TRACE(::testing::PrintToString(writing.words(out)));
    int failures = 0;
    for (const std::string most : {"300", "3000", "30000"}) {  // bytes; a sentence has room in the least
      const Files expected = expected_of(writing);
      failures += expect_whole({"prlimit", "--fsize=" + most}, writing, expected, out) == 5 ? 1 : 0;
    }
    EXPECT_GT(failures, 0);
  }
}

TEST_F(NoRoom, AFullDiskLosesNothing) {
  if (::geteuid() != 0 || Process({"unshare", "--mount", "true"}).wait() != 0) {
    GTEST_SKIP() << "A small disk of its own takes root, and a namespace of mounts.";
  }
  const std::string kept = (folder.path() / "kept").string();
  // Copies what is on the disk, which is gone with its namespace.
  const std::string script = R"(disk=$1 kept=$2; shift 2
    cp -r "$disk" "$kept" && mount -t tmpfs -o size=$SIZE tmpfs "$disk" && cp -r "$kept/." "$disk" && rm -r "$kept" || exit 99
    "$@"; code=$?
    cp -r "$disk" "$kept"; exit $code)";
  int failures = 0;
  for (const WritingCall& writing : calls()) {
    SCOPED_TRACE(::testing::PrintToString(writing.words(out)));
    for (const std::string size : {"52k", "120k"}) {
      const Files expected = expected_of(writing);
      const Words on_disk{"env", "SIZE=" + size, "unshare", "--mount", "sh", "-c", script, "sh", out, kept};
      failures += expect_whole(on_disk, writing, expected, kept) == 5 ? 1 : 0;
      fs::remove_all(kept);
    }
  }
  EXPECT_GT(failures, static_cast<int>(calls().size()) / 2);
}

TEST_F(NoRoom, AFolderThatMayNotBeWrittenIntoIsLeftAlone) {
  for (const WritingCall& writing : calls()) {
    SCOPED_TRACE(::testing::PrintToString(writing.words(out)));
    const Files expected = expected_of(writing);
    const Files before = files_in(out);
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      if (entry.is_directory()) fs::permissions(entry.path(), fs::perms(0555));
    }
    fs::permissions(out, fs::perms(0555));
    // Root, whom no permission binds, makes the call as somebody else.
    const Words as_nobody{"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"};
    EXPECT_EQ(expect_whole(::geteuid() == 0 ? as_nobody : Words{"env"}, writing, expected, out), 5);
    EXPECT_TRUE(files_in(out) == before);
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      if (entry.is_directory()) fs::permissions(entry.path(), fs::perms::all);
    }
    fs::permissions(out, fs::perms::all);
  }
}

}  // namespace
}  // namespace mapjoin::testing
