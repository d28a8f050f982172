// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <mapjoin/io/files/file_bytes.hpp>
#include <string>
#include <tests/support/file_bytes.hpp>
#include <tests/support/temporary_folder.hpp>
#include <thread>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;
using ::testing::StartsWith;

class FileBytesTest : public ::testing::Test {
 protected:
  std::string message(const fs::path& path) const {
    const auto bytes = FileBytes::read(path);
    if (bytes) return "";
    EXPECT_EQ(bytes.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(bytes.error().message, StartsWith(path.string() + ": "));
    return bytes.error().message.substr(path.string().size() + 2);
  }
  /// A copy of a gzip file without its last bytes, `missing` in number.
  fs::path cut(const fs::path& gzip, std::size_t missing) const {
    const std::string bytes = testing::content_of(gzip);
    return folder.file("cut.gz", bytes.substr(0, bytes.size() - missing));
  }
  testing::TemporaryFolder folder;
  std::string text = [] {
    std::string lines;
    for (unsigned i = 0; i < 50000; ++i) lines += std::to_string(i * i % 7919) + "\n";
    return lines;
  }();
};

TEST_F(FileBytesTest, GivesPlainAndPackedFilesAlike) {
  for (const fs::path& path : {folder.file("plain", text), testing::write_gzip(folder.path() / "packed", text)}) {
    const auto bytes = FileBytes::read(path);
    ASSERT_TRUE(bytes) << path;
    EXPECT_EQ(bytes->view(), text);
    const FileBytes copy = *bytes;
    EXPECT_EQ(copy.view(), text);
  }
}

TEST_F(FileBytesTest, JoinsTheMembersOfAGzipFile) {
  const fs::path path = testing::write_gzip(folder.path() / "two.gz", "one ");
  testing::write_gzip(path, "two", true);
  const auto bytes = FileBytes::read(path);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->view(), "one two");
}

TEST_F(FileBytesTest, ReadsAPipe) {
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << text; });
  const auto bytes = FileBytes::read(pipe);
  writer.join();
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->view(), text);
}

TEST_F(FileBytesTest, SaysInASentenceWhatIsWrongWithAFile) {
  EXPECT_EQ(message(folder.path() / "missing"), "No such file or directory");
  EXPECT_EQ(message(folder.path()), "Is a directory");
  EXPECT_EQ(message(folder.file("empty", "")), "the file is empty");
  EXPECT_EQ(message(testing::write_gzip(folder.path() / "empty.gz", "")), "the file is empty");
}

TEST_F(FileBytesTest, NamesThePackersWhoseFilesItDoesNotRead) {
  const std::string zip("PK\3\4\24\0", 6);
  EXPECT_EQ(message(folder.file("a",
                                "\xfd"
                                "7zXZ")),
            "is packed by xz; unpack it, or pack it by gzip");
  EXPECT_EQ(message(folder.file("b", "BZh91AY")), "is packed by bzip2; unpack it, or pack it by gzip");
  EXPECT_EQ(message(folder.file("c", zip)), "is packed by zip; unpack it, or pack it by gzip");
}

TEST_F(FileBytesTest, PassesOverZerosBehindAGzipStream) {
  const fs::path path = testing::write_gzip(folder.path() / "padded.gz", text);
  std::ofstream(path, std::ios::app) << std::string(512, '\0');
  const auto bytes = FileBytes::read(path);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(bytes->view(), text);
}

TEST_F(FileBytesTest, RefusesADamagedGzipStream) {
  const fs::path packed = testing::write_gzip(folder.path() / "packed.gz", text);
  EXPECT_EQ(message(cut(packed, 1)), "the gzip stream is cut off");
  EXPECT_EQ(message(cut(packed, 5000)), "the gzip stream is cut off");
  std::ofstream(packed, std::ios::app) << "more";
  EXPECT_EQ(message(packed), "bytes follow the end of the gzip stream");
  EXPECT_EQ(message(folder.file("bad.gz", "\x1f\x8bthis is no gzip stream")), "the gzip stream is damaged");
}

TEST_F(FileBytesTest, RefusesAStreamThatUnpacksToMoreThanAllowed) {
  const fs::path bomb = testing::write_gzip(folder.path() / "bomb.gz", std::string(5 << 20, '0'));
  EXPECT_TRUE(FileBytes::read(bomb, 5 << 20));
  const auto bytes = FileBytes::read(bomb, (5 << 20) - 1);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().kind, ErrorKind::kTooLarge);
  EXPECT_THAT(bytes.error().message, EndsWith("bomb.gz: unpacks to more than 4 MB"));
}

}  // namespace
}  // namespace mapjoin
