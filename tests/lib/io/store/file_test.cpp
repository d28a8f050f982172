// SPDX-License-Identifier: BSD-3-Clause
// Files other than a sound, finished store where one is read or built.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <tests/lib/io/store/store_fixture.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/sqlite.hpp>
#include <tests/support/stored_maps.hpp>
#include <type_traits>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using testing::build_store;
using testing::execute_sql;
using testing::expect_same;
using ::testing::HasSubstr;
using testing::maps_done;
using testing::random_stored_maps;

std::string with_a_bit_flipped(std::string bytes, testing::Random& random) {
  const auto bit = static_cast<std::size_t>(random.uniform(0.0, 8.0 * static_cast<double>(bytes.size())));
  bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8));
  return bytes;
}

class StoreFileTest : public testing::StoreTest<std::integral_constant<int, 2>> {
 protected:
  void SetUp() override { build_store(path, maps); }
  std::string error() const {
    const auto stored = read();
    return stored ? "no error" : stored.error().message;
  }
  /// The error of reading the store with this change made to it.
  std::string error_after(const std::string& sql) {
    const std::string before = testing::bytes_of(path);
    execute_sql(path, sql);
    const std::string message = error();
    folder.file("maps.mapjoin", before);
    return message;
  }
  StoredMaps<2> maps = random_stored_maps<2>(random, 10);
};

TEST_F(StoreFileTest, OtherFilesAreNoStores) {
  for (const std::string& content : {std::string("VERTEX_SE2 0 0 0 0\n"), std::string(), std::string(5000, 'x')}) {
    folder.file("maps.mapjoin", content);
    EXPECT_THAT(error(), HasSubstr("maps.mapjoin: not a mapjoin store"));
    EXPECT_FALSE(is_store(path));
  }
  fs::remove(path);
  EXPECT_THAT(error(), HasSubstr("not a mapjoin store"));
  execute_sql(path, "CREATE TABLE maps (a)");
  EXPECT_THAT(error(), HasSubstr("not a mapjoin store"));
  path = folder.path();
  EXPECT_THAT(error(), HasSubstr("not a mapjoin store"));
}

TEST_F(StoreFileTest, NamesTheVersionOfAnother) {
  EXPECT_THAT(error_after("PRAGMA user_version = 1"),
              HasSubstr("a mapjoin store of version 1; this mapjoin reads version 5: build it again"));
}

TEST_F(StoreFileTest, AnUnfinishedStoreIsNotRead) {
  EXPECT_THAT(error_after("DELETE FROM maps WHERE segment = 9"), HasSubstr("the local map of segment 9 is missing"));
}

TEST_F(StoreFileTest, ABitThatFlipsChangesNothingUnnoticed) {
  const std::string whole = testing::bytes_of(path);
  int noticed = 0;
  for (int flip = 0; flip < 500; ++flip) {
    folder.file("maps.mapjoin", with_a_bit_flipped(whole, random));
    const auto stored = read();
    if (stored) expect_same(*stored, maps);  // it was in no content
    noticed += stored ? 0 : 1;
  }
  EXPECT_GT(noticed, 100);
}

TEST_F(StoreFileTest, ABuildThatGoesOnTakesNoFlippedBitOver) {
  const std::string whole = testing::bytes_of(path);
  for (int flip = 0; flip < 50; ++flip) {
    folder.file("maps.mapjoin.partial", with_a_bit_flipped(whole, random));
    build_store(path, maps);
    expect_same(*read(), maps);
  }
}

TEST_F(StoreFileTest, NamesTheRowThatIsNotAsItWasWritten) {
  EXPECT_THAT(error_after("UPDATE maps SET chi2 = chi2 + 1 WHERE segment = 3"),
              HasSubstr("maps.mapjoin: damaged store: segment 3 of maps is not as it was written; build it again"));
  EXPECT_THAT(error_after("UPDATE records SET data = zeroblob(length(data)) WHERE name = 'stamps_ns'"),
              HasSubstr("of records is not as it was written"));
  EXPECT_THAT(error_after("UPDATE info SET value = 'x' WHERE key = 'source'"),
              HasSubstr("key source of info is not as it was written"));
  EXPECT_THAT(error_after("UPDATE records SET name = CAST(name AS BLOB) WHERE name = 'pose_factors'"),
              HasSubstr("of records is not as it was written"))
      << "no array of this text";
}

TEST_F(StoreFileTest, ACutLosesNothingUnnoticed) {
  const std::string whole = testing::bytes_of(path);
  for (std::size_t size = 0; size < whole.size(); size += 997) {
    folder.file("maps.mapjoin", whole.substr(0, size));
    // Bytes behind the last content may be unused.
    if (const auto stored = read()) expect_same(*stored, maps);
  }
  folder.file("maps.mapjoin", whole.substr(0, whole.size() / 2));
  EXPECT_NE(error(), "no error");
}

TEST_F(StoreFileTest, OverwrittenBytesDoNoHarm) {
  const std::string whole = testing::bytes_of(path);
  for (std::size_t at = 0; at < whole.size(); at += 101) {
    std::string changed = whole;
    changed[at] = static_cast<char>(~changed[at]);
    folder.file("maps.mapjoin", changed);
    const auto stored = read();
    EXPECT_LE(stored ? stored->maps.size() : 0, maps.maps.size()) << at;
  }
}

TEST_F(StoreFileTest, SaysWhatCannotBeWritten) {
  const auto open = [&](const fs::path& where) { return StoreWriter<2>::open(where, maps.log, maps.segments, maps.options); };
  const auto missing = open(folder.path() / "absent" / "maps.mapjoin");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(missing.error().message, HasSubstr("absent/maps.mapjoin.partial: unable to open database file"));

  fs::copy_file(path, partial);
  fs::remove(path);
  execute_sql(path, "CREATE TABLE a (b)");
  fs::rename(path, partial);
  EXPECT_THAT(open(path).error().message, HasSubstr("is in the way, and not a mapjoin store"));
}

TEST_F(StoreFileTest, HasThePermissionsOfTheStoreThatItReplaces) {
  fs::permissions(path, fs::perms(0640));
  build_store(path, maps);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms(0640));
}

TEST_F(StoreFileTest, WhatIsNoPlainFileIsKeptAndALinkStaysALink) {
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto refused = StoreWriter<2>::open(pipe, maps.log, maps.segments, maps.options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(refused.error().message, HasSubstr("pipe: a store must be a plain file; give it another name"));
  EXPECT_TRUE(fs::is_fifo(pipe));

  const fs::path loop = folder.path() / "loop";
  fs::create_symlink("loop", loop);
  EXPECT_FALSE(StoreWriter<2>::open(loop, maps.log, maps.segments, maps.options));

  const fs::path link = folder.path() / "link";
  fs::create_symlink("elsewhere", link);
  build_store(link, maps);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(fs::file_size(folder.path() / "elsewhere"), fs::file_size(path));
}

TEST_F(StoreFileTest, ANameLikeAUriIsThatOfAFile) {
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  path = "file:maps.mapjoin?mode=ro";
  build_store(path, maps);
  EXPECT_TRUE(fs::exists(folder.path() / path));
  EXPECT_EQ(error(), "no error");
  fs::current_path(before);
}

TEST_F(StoreFileTest, ADamagedOrAlteredBuildIsBegunAfresh) {
  const auto begin = [&] {
    fs::remove(partial);
    build_store(path, maps);
    fs::rename(path, partial);
  };
  begin();
  ASSERT_EQ(maps_done(path, maps), 10u);
  for (const char* sql : {"CREATE TRIGGER t AFTER INSERT ON maps BEGIN DELETE FROM maps; END", "CREATE TABLE more (a)",
                          "DELETE FROM info WHERE key = 'source'", "PRAGMA user_version = 7"}) {
    begin();
    fs::rename(partial, path);
    execute_sql(path, sql);
    fs::rename(path, partial);
    EXPECT_EQ(maps_done(path, maps), 0u) << sql;
  }
}

TEST_F(StoreFileTest, WhatIsLeftOfADamagedBuildIsBegunAfreshAndTold) {
  const std::string whole = testing::bytes_of(path);
  std::string overwritten = whole;
  std::fill_n(overwritten.rbegin(), testing::kStorePage, 'x');
  std::string noise(100'000, '\0');
  std::generate(noise.begin(), noise.end(), [&] { return static_cast<char>(random.uniform(-128.0, 127.0)); });
  for (const std::string& left : {overwritten, whole.substr(0, whole.size() / 2), whole.substr(0, 50), noise}) {
    folder.file("maps.mapjoin.partial", left);
    const auto writer = StoreWriter<2>::open(path, maps.log, maps.segments, maps.options);
    ASSERT_TRUE(writer) << writer.error().message;
    EXPECT_TRUE(writer->found_damaged()) << left.size();
    EXPECT_TRUE(writer->done().empty());
  }
  build_store(path, maps);
  EXPECT_TRUE(testing::bytes_of(path) == whole);
  EXPECT_FALSE((StoreWriter<2>::open(path, maps.log, maps.segments, maps.options)->found_damaged()));
}

TEST_F(StoreFileTest, ABuildThatWasKilledInTheMidstOfABatchIsNotRead) {
  const pid_t child = fork();
  if (child == 0) {
    sqlite3* database = nullptr;
    sqlite3_open(path.c_str(), &database);
    // With a cache of one page and values of many, data that are not committed go into the file.
    const char* sql = "PRAGMA cache_size = 1; BEGIN; UPDATE maps SET information = zeroblob(1000000)";
    sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_THAT(error(), HasSubstr("maps.mapjoin: unfinished store: its writer was interrupted; the same `mapjoin build` again"));
}

TEST_F(StoreFileTest, OneBuildAtATime) {
  const auto first = StoreWriter<2>::open(path, maps.log, maps.segments, maps.options);
  ASSERT_TRUE(first);
  const auto second = StoreWriter<2>::open(path, maps.log, maps.segments, maps.options);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("maps.mapjoin.partial: another process is writing it"));
  path = partial;  // to read the unfinished store
  EXPECT_THAT(error(), HasSubstr("maps.mapjoin.partial: another process is writing it"));
}

}  // namespace
}  // namespace mapjoin
