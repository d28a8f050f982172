// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <mapjoin/io/open.hpp>
#include <string>
#include <tests/support/error_of.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>
#include <thread>

namespace mapjoin {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

class OpenLogTest : public ::testing::Test {
 protected:
  testing::TemporaryFolder folder;
};

TEST_F(OpenLogTest, KnowsTextFormatsByTheirContentPlainAndPacked) {
  for (const std::string content :
       {"# a comment\n\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n", "FIX 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
        "EDGE2 0 1 1 0 0 1 0 0 1 0 1\n", "ODOM 0 1 1 0 0 1 0 0 1 0 1\n", "STEP image 1 0 0 1 0 1 0 0 1\n"}) {
    for (const auto& path : {folder.file("some.mat", content), testing::write_gzip(folder.path() / "packed", content)}) {
      const auto log = open_log(path);
      ASSERT_TRUE(log) << log.error().message;
      EXPECT_EQ(std::get<Log<2>>(*log).odometry().size(), 1u) << content;
      EXPECT_EQ(std::get<Log<2>>(*log).source, path.string());
    }
  }
}

TEST_F(OpenLogTest, SaysWhatIsWrongWithAFileInOneSentence) {
  const auto message = [&](const std::filesystem::path& path) { return testing::error_of(open_log(path)); };
  EXPECT_THAT(message(folder.path() / "missing"), EndsWith("missing: No such file or directory"));
  EXPECT_THAT(message(folder.path()), HasSubstr(": a folder is a log if Barcodes.dat (of UTIAS MRCLAM) or map.g2o"));
  EXPECT_THAT(message(folder.file("empty", "")), EndsWith("empty: the file is empty"));
  EXPECT_THAT(message(folder.file("blank", "# nothing\n\n")), EndsWith("blank: the file has nothing but blanks and comments"));
  EXPECT_THAT(message(folder.file("prose", "\nDear reader")),
              HasSubstr("prose:2:1: no log format has lines that begin with 'Dear'; --from names"));
}

TEST_F(OpenLogTest, RefusesNoFilesAtAll) {
  EXPECT_EQ(testing::error_of(open_logs({})), "no log is named");
  EXPECT_EQ(testing::error_of(open_several_maps({})), "no local maps are named");
}

TEST_F(OpenLogTest, ReadsAMatFileFromAPipe) {
  // A MAT file without variables; the error shows that it was read.
  const std::string header = std::string("MATLAB 5.0 MAT-file").append(105, ' ') + std::string("\0\1IM", 4);
  const auto pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << header; });
  const auto log = open_log(pipe);
  writer.join();
  EXPECT_THAT(log.error().message, HasSubstr("pipe: holds neither the variable"));
}

}  // namespace
}  // namespace mapjoin
