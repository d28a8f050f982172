// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/lib/io/store/store_fixture.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/sqlite.hpp>
#include <tests/support/store_checksums.hpp>
#include <tests/support/stored_maps.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

/// Writes a store of ten maps, none of whose arrays is empty.
void write_store(const std::filesystem::path& path) {
  testing::Random random;
  testing::build_store(path, testing::random_stored_maps<2>(random, 10));
}

TEST(StoreCheck, NothingDamagedGetsThrough) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "maps.mapjoin";
  write_store(path);
  ASSERT_TRUE(read_store(path));
  const std::string sound = testing::bytes_of(path);
  for (const char* sql : {
           "UPDATE maps SET segment = 10 WHERE segment = 9",
           "INSERT INTO maps (segment, crc32) VALUES (11, 0)",
           "UPDATE maps SET base = 1 WHERE segment = 3",
           "UPDATE maps SET chi2 = 9e999 WHERE segment = 3",
           "UPDATE maps SET poses = x'ffffff7f' WHERE segment = 3",
           "UPDATE maps SET segment = -1 WHERE segment = 0",
           "UPDATE maps SET poses = x'0000' WHERE segment = 3",
           "UPDATE maps SET poses = x'' WHERE segment = 3",
           "UPDATE maps SET features = zeroblob(20) WHERE segment = 3",
           "UPDATE maps SET features = zeroblob(40) WHERE segment = 3",
           "UPDATE maps SET pose_estimates = zeroblob(48) WHERE segment = 3",
           "UPDATE maps SET feature_estimates = zeroblob(16) WHERE segment = 3",
           "UPDATE maps SET features = x'ffffffff' || substr(features, 5) WHERE segment = 3",
           "UPDATE maps SET features = substr(features, 1, 4) || substr(features, 1, 4) || substr(features, 9) WHERE segment = "
           "3",
           "UPDATE maps SET pose_estimates = x'000000000000f87f' || substr(pose_estimates, 9) WHERE segment = 3",
           "UPDATE maps SET feature_estimates = x'000000000000f87f' || substr(feature_estimates, 9) WHERE segment = 3",
           "UPDATE maps SET information = x'000000000000f87f' || substr(information, 9) WHERE segment = 3",
           "UPDATE maps SET information = information || zeroblob(8) WHERE segment = 3",
           "UPDATE maps SET information = zeroblob(16) WHERE segment = 3",
           "UPDATE maps SET information = NULL WHERE segment = 3",
           "UPDATE maps SET information = 'text' WHERE segment = 3",
           "UPDATE maps SET information = x'00000000000059c0' || substr(information, 9) WHERE segment = 3",
           "UPDATE records SET data = substr(data, 1, length(data) - 1) WHERE name = 'pose_factors'",
           "UPDATE records SET data = 7 WHERE name = 'feature_factors'",
           "UPDATE records SET data = zeroblob(12) WHERE name = 'poses'",
           "UPDATE records SET data = zeroblob(9) WHERE name = 'segments'",
           "UPDATE records SET data = zeroblob(8) WHERE name = 'stamps_ns'",
           "UPDATE records SET data = zeroblob(24) WHERE name = 'initial_poses'",
           "UPDATE records SET data = x'feffffff' || substr(data, 5) WHERE name = 'pose_factors'",
           "UPDATE records SET data = x'ffffff7f' || substr(data, 5) WHERE name = 'feature_factors'",
           "UPDATE records SET data = x'ffffff7f' || substr(data, 5) WHERE name = 'fixed'",
           "UPDATE records SET data = substr(data, 1, 8) || x'000000000000f07f' || substr(data, 17) WHERE name = "
           "'pose_factors'",
           "UPDATE records SET data = substr(data, 1, 32) || x'00000000000059c0' || substr(data, 41) WHERE name = "
           "'pose_factors'",
           "UPDATE records SET data = x'0500000005000000' || substr(data, 9) WHERE name = 'pose_factors'",
           "UPDATE records SET data = substr(data, 1, 12) || substr(data, 1, 12) || substr(data, 25) WHERE name = 'poses'",
           "UPDATE records SET data = substr(data, 9, 8) || substr(data, 1, 8) || substr(data, 17) WHERE name = 'features'",
           "UPDATE records SET data = data || data WHERE name = 'poses'",
           "UPDATE records SET data = x'000000000000f87f' || substr(data, 9) WHERE name = 'initial_features'",
           "INSERT INTO records VALUES (-1, 'pose_factors', x'00', 0)",
           "INSERT INTO records VALUES (99, 'sessions', zeroblob(8), 0)",
           "DELETE FROM records",
           "DELETE FROM info WHERE key = 'dimension'",
           "UPDATE info SET value = '4' WHERE key = 'dimension'",
           "UPDATE info SET value = '2' WHERE key = 'covariance'",
           "UPDATE info SET value = '-1' WHERE key = 'unassociated'",
           "UPDATE info SET value = 'many' WHERE key = 'repaired_informations'",
           "DELETE FROM info WHERE key = 'pose_error'",
           "UPDATE info SET value = '99999999999999999999' WHERE key = 'repaired_informations'",
           "UPDATE info SET value = '4294967298' WHERE key = 'dimension'",
           "UPDATE info SET value = 'inf' WHERE key = 'largest_asymmetry'",
           "PRAGMA journal_mode = WAL",
           "CREATE TABLE more (a)",
           "CREATE TRIGGER t AFTER INSERT ON maps BEGIN DELETE FROM maps; END",
           "DROP TABLE maps; CREATE VIEW maps AS SELECT 1",
           "ALTER TABLE maps ADD COLUMN computed AS (zeroblob(1000000000))",
       }) {
    folder.file("maps.mapjoin", sound);
    testing::execute_sql(path, sql);
    testing::seal(path);  // what a stranger wrote as it is
    const auto stored = read_store(path);
    ASSERT_FALSE(stored) << sql;
    EXPECT_THAT(stored.error().message, ::testing::Not(HasSubstr("not as it was written"))) << sql;
    EXPECT_EQ(stored.error().kind, ErrorKind::kBadInput) << sql;
    EXPECT_THAT(stored.error().message, HasSubstr("maps.mapjoin: ")) << sql;
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1) << "left beside it: " << sql;
  }
}

TEST(StoreCheck, SaysInOneLineThatAPageIsDamaged) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "maps.mapjoin";
  write_store(path);
  const std::string sound = testing::bytes_of(path);
  ASSERT_GT(sound.size(), 4 * testing::kStorePage);
  for (std::size_t page = 1; page < sound.size() / testing::kStorePage; ++page) {
    std::string damaged = sound;
    damaged.replace(page * testing::kStorePage, 8, "\n\x1b[2Jno\n");
    folder.file("maps.mapjoin", damaged);
    const auto stored = read_store(path);
    ASSERT_FALSE(stored) << page;
    EXPECT_THAT(stored.error().message, ::testing::MatchesRegex("[ -~]*maps.mapjoin: damaged store: [ -~]+")) << page;
  }
}

}  // namespace
}  // namespace mapjoin
