// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <mapjoin/io/store/database.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <tests/lib/io/store/store_fixture.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/sqlite.hpp>
#include <tests/support/store_checksums.hpp>
#include <tests/support/stored_maps.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using testing::build_store;
using ::testing::ElementsAre;
using testing::execute_sql;
using testing::expect_same;
using ::testing::HasSubstr;
using testing::maps_done;
using testing::random_stored_maps;
using testing::seal;
using testing::StoreTest;

TYPED_TEST_SUITE(StoreTest, testing::Dimensions);

TYPED_TEST(StoreTest, GivesBackEveryBitOfLogSegmentsAndMaps) {
  auto maps = random_stored_maps<TestFixture::kDim>(this->random, 20);
  maps.log.skipped = {{"VERTEX_OTHER lines", 3}, {"self-edges", 1}};
  maps.log.conventions.repairs.missing = 2;
  build_store(this->path, maps);
  EXPECT_FALSE(fs::exists(this->partial));
  EXPECT_TRUE(is_store(this->path));
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
  EXPECT_EQ(read->log.skipped, maps.log.skipped);
  EXPECT_EQ(read->log.conventions.repairs.missing, 2);
}

TYPED_TEST(StoreTest, GivesBackALogThatTakesManyChunks) {
  auto maps = random_stored_maps<TestFixture::kDim>(this->random, 3);
  for (int i = 0; i < 40000; ++i) {
    maps.log.graph.feature_factors.push_back(
        testing::random_feature_observation<TestFixture::kDim>(this->random, PoseIndex(i % 8), FeatureIndex(i % 5)));
  }
  put_in_order(maps.log);
  build_store(this->path, maps);
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, GivesBackAnOrderThatItsEdgesDoNotTell) {
  constexpr int kDim = TestFixture::kDim;
  LogBuilder<kDim> builder("some.log");
  for (const auto& [base, target] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{{0, 1}, {2, 3}, {3, 1}}) {
    builder.add_pose_edge({0, base}, {0, target}, this->random.template pose<kDim>(),
                          this->random.template information<kPoseDof<kDim>>());
  }
  for (const std::uint64_t pose : {0u, 1u, 2u, 3u}) {
    builder.add_pose({0, pose}, this->random.template pose<kDim>());
    builder.add_stamp({0, pose}, static_cast<std::int64_t>(pose));
  }
  builder.fix({0, 1});
  StoredMaps<kDim> maps;
  maps.log = std::move(builder).finish(PoseIds{{0, 3}, {0, 0}, {0, 2}, {0, 1}}).value();
  build_store(this->path, maps);
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, ASegmentThatDidNotDetermineItsMapIsReadAsASpan) {
  constexpr int kDim = TestFixture::kDim;
  auto maps = random_stored_maps<kDim>(this->random, 3);
  auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add(0, maps.maps[0]) && writer->add(1, std::nullopt) && writer->add(2, maps.maps[2]));
  EXPECT_THAT(writer->done(), ElementsAre(0, 1, 2));
  ASSERT_TRUE(writer->finish());
  maps.maps.erase(maps.maps.begin() + 1);
  maps.segments[1].is_map = false;
  const auto read = this->read();
  ASSERT_TRUE(read) << read.error().message;
  expect_same(*read, maps);
}

TYPED_TEST(StoreTest, TheFirstOfManyMapsThatIsDamagedIsNamed) {
  const auto maps = random_stored_maps<TestFixture::kDim>(this->random, 40, 50);  // large maps
  build_store(this->path, maps);
  for (const int segment : {39, 3}) {
    execute_sql(this->path, fmt::format("UPDATE maps SET information = x'00' WHERE segment = {}", segment));
    ASSERT_TRUE(seal(this->path));
    for (const std::size_t threads : {1u, 4u}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      const auto read = this->read();
      ASSERT_FALSE(read);
      EXPECT_THAT(read.error().message, HasSubstr(fmt::format("the sizes of map {} do not agree", segment)));
    }
  }
}

TYPED_TEST(StoreTest, StaysAsItIsWhileItIsRead) {
  build_store(this->path, random_stored_maps<TestFixture::kDim>(this->random, 3));
  auto database = store::Database::open_read_only(this->path);
  ASSERT_TRUE(database && database->integer("SELECT count(*) FROM maps"));
  EXPECT_FALSE(store::Database::open(this->path).and_then([](auto other) { return other.execute("DELETE FROM maps"); }));
  database = store::Database::open(this->path);
  EXPECT_TRUE(database->execute("DELETE FROM maps"));
}

TYPED_TEST(StoreTest, ABuildThatWasKilledGoesOnAndEndsWithTheSameBytes) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 1000);
  build_store(this->path, maps);
  const std::string uninterrupted = testing::bytes_of(this->path);
  fs::remove(this->path);

  std::size_t done_before = 0;
  for (const std::size_t kill_after : {100u, 300u, 301u, 700u, 999u}) {
    const pid_t child = fork();
    if (child == 0) {
      build_store(this->path, maps, [&](std::size_t done) {
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
  build_store(this->path, maps);
  EXPECT_TRUE(testing::bytes_of(this->path) == uninterrupted);
  expect_same(*this->read(), maps);
}

TYPED_TEST(StoreTest, ABuildOfAnotherLogSplitOrOptionsBeginsAfresh) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 300);
  const auto begin = [&] {
    auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options);
    for (std::size_t k = writer->done().size(); k < 260; ++k) ASSERT_TRUE(writer->add(k, maps.maps[k]));
  };
  begin();
  ASSERT_EQ(maps_done(this->path, maps), 256u);
  auto other = maps;
  other.options = "--poses-per-map 3";
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.log.graph.feature_factors.back().measured[0] += 1e-12;
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.log.graph.feature_factors.pop_back();
  EXPECT_EQ(maps_done(this->path, other), 0u);

  begin();
  other = maps;
  other.segments.pop_back();
  EXPECT_EQ(maps_done(this->path, other), 0u);
  build_store(this->path, other);
  expect_same(*this->read(), other);
}

TYPED_TEST(StoreTest, AShareOfTheMapsIsOneOfSoMany) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 0);
  auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options, {}, {1, 3});
  ASSERT_TRUE(writer && writer->finish());
  EXPECT_EQ(this->read()->share, (Share{1, 3}));
  EXPECT_TRUE(this->read()->portion.is_whole());
  execute_sql(this->path, "UPDATE info SET value = '4/3' WHERE key = 'part'");
  ASSERT_TRUE(seal(this->path));
  EXPECT_THAT(this->read().error().message, HasSubstr("damaged store: info part makes no sense"));
  execute_sql(this->path, "DELETE FROM info WHERE key = 'part'");
  EXPECT_TRUE(this->read()->share.is_whole());
}

TYPED_TEST(StoreTest, SaysThatFeaturesAreSharedWhereTheUserDid) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 0);
  const auto write = [&](bool are_shared) {
    auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options, {}, {}, are_shared);
    ASSERT_TRUE(writer && writer->finish());
    EXPECT_EQ(this->read()->features_are_shared, are_shared);
  };
  write(false);
  write(true);
  execute_sql(this->path, "UPDATE info SET value = 'own' WHERE key = 'features'");
  ASSERT_TRUE(seal(this->path));
  EXPECT_THAT(this->read().error().message, HasSubstr("damaged store: info features makes no sense"));
}

TYPED_TEST(StoreTest, MapsAreAddedInOrderAndAllOfThem) {
  constexpr int kDim = TestFixture::kDim;
  const auto maps = random_stored_maps<kDim>(this->random, 3);
  auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options);
  ASSERT_TRUE(writer);
  EXPECT_THROW((void)writer->add(1, maps.maps[1]), std::invalid_argument);
  EXPECT_THROW((void)writer->add(0, maps.maps[1]), std::invalid_argument) << "a map of another segment";
  EXPECT_THROW((void)writer->add(0, LocalMap<kDim>()), std::invalid_argument) << "without its end pose";
  LocalMap<kDim> wrong = maps.maps[0];
  wrong.information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)writer->add(0, wrong), std::invalid_argument);
  wrong = maps.maps[0];
  wrong.features[0] = FeatureIndex(maps.log.features.size());
  EXPECT_THROW((void)writer->add(0, wrong), std::invalid_argument);
  EXPECT_THAT(writer->to_do(), ElementsAre(0, 1, 2)) << "nothing was added";
  EXPECT_THROW((void)writer->finish(), std::logic_error);
  for (std::size_t k = 0; k < 3; ++k) ASSERT_TRUE(writer->add(k, maps.maps[k]));
  EXPECT_TRUE(writer->finish());
  EXPECT_THROW((void)writer->finish(), std::logic_error) << "it is";
}

TYPED_TEST(StoreTest, HasNoPlaceForLosses) {
  constexpr int kDim = TestFixture::kDim;
  auto maps = random_stored_maps<kDim>(this->random, 3);
  maps.log.graph.feature_factors[0].loss = Loss::truncated(1.0);
  const auto writer = StoreWriter<kDim>::open(this->path, maps.log, maps.segments, maps.options);
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message, HasSubstr("a store has no place for losses of factors"));
  EXPECT_FALSE(fs::exists(this->partial));
}

}  // namespace
}  // namespace mapjoin
