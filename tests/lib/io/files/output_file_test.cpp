// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <mapjoin/io/files/output_file.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using testing::content_of;
using ::testing::HasSubstr;

class OutputFileTest : public ::testing::Test {
 protected:
  std::size_t entries() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder.path()), {})); }
  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "map.g2o";
};

TEST_F(OutputFileTest, AppearsWholeOnCommit) {
  std::string expected;
  auto file = OutputFile::create(path);
  ASSERT_TRUE(file);
  for (int i = 0; i < 100000; ++i) {
    const std::string line = std::to_string(i) + "\n";
    file->write(line);
    expected += line;
  }
  EXPECT_FALSE(fs::exists(path));
  EXPECT_TRUE(file->commit());
  EXPECT_EQ(content_of(path), expected);
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, LeavesWhatWasThereWhenNotCommitted) {
  std::ofstream(path) << "before";
  {
    auto file = OutputFile::create(path);
    ASSERT_TRUE(file);
    file->write("half");
  }
  EXPECT_EQ(content_of(path), "before");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, ClearsWhatAKilledProcessLeft) {
  std::ofstream(path.string() + ".mapjoin-tmp") << "half of something long";
  auto file = OutputFile::create(path);
  ASSERT_TRUE(file);
  file->write("whole");
  EXPECT_TRUE(file->commit());
  EXPECT_EQ(content_of(path), "whole");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, OneWriterAtATime) {
  auto first = OutputFile::create(path);
  ASSERT_TRUE(first);
  first->write("first");
  const auto second = OutputFile::create(path);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(second.error().message, HasSubstr("map.g2o: another process is writing it"));
  EXPECT_TRUE(first->commit());
  EXPECT_EQ(content_of(path), "first");
  EXPECT_TRUE(OutputFile::create(path));
}

TEST_F(OutputFileTest, WritesThroughALinkAndToADevice) {
  std::ofstream(path) << "before";
  const fs::path link = folder.path() / "link";
  fs::create_symlink(path, link);
  auto file = OutputFile::create(link);
  ASSERT_TRUE(file);
  file->write("after");
  EXPECT_TRUE(file->commit());
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(content_of(path), "after");

  auto null = OutputFile::create("/dev/null");
  ASSERT_TRUE(null);
  null->write("gone");
  EXPECT_TRUE(null->commit());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputFileTest, WritesThroughALinkThatLeadsNowhereYet) {
  const fs::path link = folder.path() / "link";
  fs::create_symlink("second", link);
  fs::create_symlink("map.g2o", folder.path() / "second");
  auto file = OutputFile::create(link);
  ASSERT_TRUE(file);
  file->write("content");
  EXPECT_TRUE(file->commit());
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(content_of(path), "content");
}

TEST_F(OutputFileTest, HasThePermissionsOfTheFileThatItReplaces) {
  std::ofstream(path) << "before";
  fs::permissions(path, fs::perms(0640));
  EXPECT_TRUE(write_file(path, "after"));
  EXPECT_EQ(content_of(path), "after");
  EXPECT_EQ(fs::status(path).permissions(), fs::perms(0640));
}

TEST_F(OutputFileTest, RefusesALoopOfLinks) {
  fs::create_symlink("other", path);
  fs::create_symlink(path.filename(), folder.path() / "other");
  const auto file = OutputFile::create(path);
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("map.g2o: Too many levels of symbolic links"));
  EXPECT_EQ(entries(), 2u);
}

TEST_F(OutputFileTest, GoesOnBehindWhatAnOpenFileHasInIt) {
  std::ofstream(path) << "before ";
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_APPEND);
  for (const std::string folder_of_descriptors : {"/dev/fd/", "/proc/self/fd/"}) {
    auto file = OutputFile::create(folder_of_descriptors + std::to_string(descriptor));
    ASSERT_TRUE(file);
    file->write("after ");
    EXPECT_TRUE(file->commit());
  }
  ::close(descriptor);
  EXPECT_EQ(content_of(path), "before after after ");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, SaysWhyItCannotWrite) {
  const auto missing = OutputFile::create(folder.path() / "no" / "map.g2o");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(missing.error().message, HasSubstr("no/map.g2o: No such file or directory"));

  auto full = OutputFile::create("/dev/full");
  ASSERT_TRUE(full);
  full->write("lost");
  const auto committed = full->commit();
  ASSERT_FALSE(committed);
  EXPECT_EQ(committed.error().kind, ErrorKind::kCannotWrite);
  EXPECT_EQ(committed.error().message, "/dev/full: No space left on device");
}

}  // namespace
}  // namespace mapjoin
