// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <tests/support/dimensions.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/sqlite.hpp>
#include <tests/support/stored_maps.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using testing::execute_sql;
using testing::expect_same;
using ::testing::HasSubstr;
using testing::Random;
using testing::random_stored_maps;

/// Goes on from what is done; `after` is called with the number of maps done after every one.
template <int Dim>
void build(const fs::path& path, const StoredMaps<Dim>& maps, const std::function<void(std::size_t)>& after = {}) {
  auto writer = StoreWriter<Dim>::open(path, maps.log, maps.stretches, maps.options);
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::size_t k = writer->done().size(); k < maps.maps.size(); ++k) {
    ASSERT_TRUE(writer->add(k, maps.maps[k]));
    if (after) after(k + 1);
  }
  const auto finished = writer->finish();
  ASSERT_TRUE(finished) << finished.error().message;
}

template <int Dim>
std::size_t maps_done(const fs::path& path, const StoredMaps<Dim>& maps) {
  return StoreWriter<Dim>::open(path, maps.log, maps.stretches, maps.options)->done().size();
}

template <typename D>
class StoreTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  Expected<StoredMaps<kDim>> read() const {
    return read_store(path).map([](AnyStoredMaps&& any) { return std::get<StoredMaps<kDim>>(std::move(any)); });
  }
  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "maps.mapjoin";
  fs::path partial = folder.path() / "maps.mapjoin.partial";
  Random random;
};
TYPED_TEST_SUITE(StoreTest, testing::Dimensions);

TYPED_TEST(StoreTest, GivesBackEveryBitOfLogStretchesAndMaps) {
  const auto maps = random_stored_maps<TestFixture::kDim>(this->random, 20);
  build(this->path, maps);
  EXPECT_FALSE(fs::exists(this->partial));
  EXPECT_TRUE(is_store(this->path));
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, GivesBackALogThatTakesManyChunks) {
  auto maps = random_stored_maps<TestFixture::kDim>(this->random, 3);
  for (int i = 0; i < 40000; ++i) {
    maps.log.observations.push_back(testing::random_feature_observation<TestFixture::kDim>(this->random, i % 8, i % 5));
  }
  std::stable_sort(maps.log.observations.begin(), maps.log.observations.end(),
                   [](const auto& a, const auto& b) { return a.base < b.base; });
  build(this->path, maps);
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, AStretchThatDidNotDetermineItsMapIsReadAsASpan) {
  constexpr int kDim = TestFixture::kDim;
  auto maps = random_stored_maps<kDim>(this->random, 3);
  auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.stretches, maps.options);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add(0, maps.maps[0]) && writer->add(1, std::nullopt) && writer->add(2, maps.maps[2]));
  EXPECT_THAT(writer->done(), ElementsAre(0, 1, 2));
  ASSERT_TRUE(writer->finish());
  maps.maps.erase(maps.maps.begin() + 1);
  maps.stretches[1].is_map = false;
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, TheFirstOfManyMapsThatIsDamagedIsNamed) {
  const auto maps = random_stored_maps<TestFixture::kDim>(this->random, 40, 50);  // more than are read at once
  build(this->path, maps);
  for (const int stretch : {39, 3}) {
    execute_sql(this->path, fmt::format("UPDATE maps SET information = x'00' WHERE stretch = {}", stretch));
    for (const std::size_t threads : {1u, 4u}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      const auto read = this->read();
      ASSERT_FALSE(read);
      EXPECT_THAT(read.error().message, HasSubstr(fmt::format("the sizes of map {} do not agree", stretch)));
    }
  }
}

TYPED_TEST(StoreTest, StaysAsItIsWhileItIsRead) {
  build(this->path, random_stored_maps<TestFixture::kDim>(this->random, 3));
  auto database = store::Database::open_read_only(this->path);
  ASSERT_TRUE(database && database->integer("SELECT count(*) FROM maps"));
  EXPECT_FALSE(store::Database::open(this->path).and_then([](auto other) { return other.execute("DELETE FROM maps"); }));
  database = store::Database::open(this->path);
  EXPECT_TRUE(database->execute("DELETE FROM maps"));
}

TYPED_TEST(StoreTest, ABuildThatWasKilledGoesOnAndEndsWithTheSameBytes) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 1000);
  build(this->path, maps);
  const std::string uninterrupted = testing::bytes_of(this->path);
  fs::remove(this->path);

  std::size_t done_before = 0;
  for (const std::size_t kill_after : {100u, 300u, 301u, 700u, 999u}) {
    const pid_t child = fork();
    if (child == 0) {
      build(this->path, maps, [&](std::size_t done) {
        if (done == kill_after) kill(getpid(), SIGKILL);
      });
      _exit(1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << kill_after;
    EXPECT_FALSE(fs::exists(this->path));
    const std::size_t done = maps_done(this->path, maps);
    EXPECT_LE(done, kill_after);
    EXPECT_GT(done + 257, kill_after);
    EXPECT_GE(done, done_before);
    done_before = done;
  }
  EXPECT_EQ(done_before, 768u);
  build(this->path, maps);
  EXPECT_TRUE(testing::bytes_of(this->path) == uninterrupted);
  expect_same(*this->read(), maps);
}

TYPED_TEST(StoreTest, ABuildOfAnotherLogSplitOrOptionsBeginsAfresh) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 300);
  const auto begin = [&] {
    auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.stretches, maps.options);
    for (std::size_t k = writer->done().size(); k < 260; ++k) ASSERT_TRUE(writer->add(k, maps.maps[k]));
  };
  begin();
  ASSERT_EQ(maps_done(this->path, maps), 256u);
  auto other = maps;
  other.options = "--poses-per-map 3";
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.log.observations.back().measured[0] += 1e-12;
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.log.observations.pop_back();
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.stretches.pop_back();
  EXPECT_EQ(maps_done(this->path, other), 0u);
  build(this->path, other);
  expect_same(*this->read(), other);
}

TYPED_TEST(StoreTest, MapsAreAddedInOrderAndAllOfThem) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 3);
  auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.stretches, maps.options);
  ASSERT_TRUE(writer);
  EXPECT_THROW((void)writer->add(1, maps.maps[1]), std::invalid_argument);
  EXPECT_THROW((void)writer->finish(), std::logic_error);
}

class StoreFileTest : public StoreTest<std::integral_constant<int, 2>> {
 protected:
  void SetUp() override { build(path, maps); }
  std::string error() const {
    const auto stored = read();
    return stored ? "no error" : stored.error().message;
  }
  /// The error of a store with this change made to it.
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
  EXPECT_THAT(error_after("PRAGMA user_version = 2"), HasSubstr("a mapjoin store of version 2; this mapjoin reads version 1"));
}

TEST_F(StoreFileTest, AnUnfinishedStoreIsNotRead) {
  EXPECT_THAT(error_after("DELETE FROM maps WHERE stretch = 9"), HasSubstr("the local map of stretch 9 is missing"));
}

TEST_F(StoreFileTest, ACutLosesNothingUnnoticed) {
  const std::string whole = testing::bytes_of(path);
  for (std::size_t size = 0; size < whole.size(); size += 997) {
    folder.file("maps.mapjoin", whole.substr(0, size));
    // Behind the last content there may be unused bytes.
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
  const auto open = [&](const fs::path& where) { return StoreWriter<2>::open(where, maps.log, maps.stretches, maps.options); };
  const auto missing = open(folder.path() / "absent" / "maps.mapjoin");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(missing.error().message, HasSubstr("absent/maps.mapjoin.partial: unable to open database file"));

  folder.file("maps.mapjoin.partial", "somebody's notes");
  EXPECT_THAT(open(path).error().message, HasSubstr("maps.mapjoin.partial: file is not a database"));
  EXPECT_EQ(testing::bytes_of(partial), "somebody's notes");
  fs::remove(partial);
  fs::copy_file(path, partial);
  fs::remove(path);
  execute_sql(path, "CREATE TABLE a (b)");
  fs::rename(path, partial);
  EXPECT_THAT(open(path).error().message, HasSubstr("is in the way, and not a mapjoin store"));
}

TEST_F(StoreFileTest, ADamagedOrAlteredBuildIsBegunAfresh) {
  const auto begin = [&] {
    fs::remove(partial);
    build(path, maps);
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
  begin();
  std::string bytes = testing::bytes_of(partial);
  std::fill(bytes.end() - 32768, bytes.end(), 'x');  // a page
  folder.file("maps.mapjoin.partial", bytes);
  EXPECT_EQ(maps_done(path, maps), 0u);
}

TEST_F(StoreFileTest, ABuildThatWasKilledInTheMidstOfABatchIsNotRead) {
  const pid_t child = fork();
  if (child == 0) {
    sqlite3* database = nullptr;
    sqlite3_open(path.c_str(), &database);
    // A cache of one page, and values of many: what is not committed goes into the file.
    const char* sql = "PRAGMA cache_size = 1; BEGIN; UPDATE maps SET information = zeroblob(1000000)";
    sqlite3_exec(database, sql, nullptr, nullptr, nullptr);
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_THAT(error(), HasSubstr("maps.mapjoin: unfinished store: its writer was interrupted"));
}

TEST_F(StoreFileTest, OneBuildAtATime) {
  const auto first = StoreWriter<2>::open(path, maps.log, maps.stretches, maps.options);
  ASSERT_TRUE(first);
  const auto second = StoreWriter<2>::open(path, maps.log, maps.stretches, maps.options);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("maps.mapjoin.partial: another process is writing it"));
  path = partial;  // Nor is it read.
  EXPECT_THAT(error(), HasSubstr("maps.mapjoin.partial: another process is writing it"));
}

}  // namespace
}  // namespace mapjoin
