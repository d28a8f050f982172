// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <tests/lib/io/store/store_fixture.hpp>
#include <tests/support/file_bytes.hpp>
#include <tests/support/stored_maps.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

constexpr const char* kTextMap = "0\n3\n-1 1\n-1 2\n-1 3\n1 0 0\n0 1 0\n0 0 1\n";

TEST(OpenMaps, KnowsFoldersArchivesAndStoresByTheirContent) {
  const testing::TemporaryFolder folder;
  folder.file("localmap_1.txt", kTextMap);
  EXPECT_TRUE(std::holds_alternative<SubmapSet<2>>(open_maps(folder.path()).value()));

  const auto archive = folder.file("maps", testing::tar_of({{"localmap_1.txt", kTextMap}}));
  EXPECT_TRUE(std::holds_alternative<SubmapSet<2>>(open_maps(archive).value()));

  testing::Random random;
  const auto store = folder.path() / "store";
  testing::build_store(store, testing::random_stored_maps<3>(random, 1));
  EXPECT_TRUE(std::holds_alternative<StoredMaps<3>>(open_maps(store).value()));

  for (const auto& path : {folder.path(), archive, store}) EXPECT_TRUE(may_hold_maps(path)) << path;
  EXPECT_FALSE(may_hold_maps(folder.path() / "localmap_1.txt"));
  EXPECT_FALSE(may_hold_maps(folder.path() / "nowhere"));
  EXPECT_FALSE(may_hold_maps(testing::TemporaryFolder().path())) << "has none";
}

TEST(OpenMaps, SaysOfOtherFilesWhatTheyAreNot) {
  const testing::TemporaryFolder folder;
  const auto log = folder.file("log.g2o", "VERTEX_SE2 0 0 0 0\n");
  EXPECT_THAT(open_maps(log).error().message, HasSubstr("log.g2o: neither a folder nor a tar archive nor a mapjoin store"));
  EXPECT_THAT(open_maps(folder.path() / "absent").error().message, HasSubstr("absent: No such file"));
}

}  // namespace
}  // namespace mapjoin
