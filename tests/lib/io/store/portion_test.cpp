// SPDX-License-Identifier: BSD-3-Clause
// Stores of portions of a log, and stores read in pieces.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/pieces.hpp>
#include <tests/lib/io/store/store_fixture.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/sqlite.hpp>
#include <tests/support/store_checksums.hpp>
#include <tests/support/stored_maps.hpp>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;
using testing::build_store;
using testing::execute_sql;
using ::testing::HasSubstr;
using testing::seal;
using testing::StoreTest;

template <typename D>
class PortionTest : public StoreTest<D> {
 protected:
  static constexpr int kDim = D::value;

  /// Builds the store of portion `index` of `count`: every `count`-th factor and map, from `index` on.
  fs::path build(std::size_t index, std::size_t count) const {
    StoredMaps<kDim> some = whole;
    some.maps.clear();
    const auto keep = [&](auto& list) {
      const auto all = std::exchange(list, {});
      for (std::size_t k = index; k < all.size(); k += count) list.push_back(all[k]);
    };
    keep(some.log.graph.pose_factors);
    keep(some.log.graph.feature_factors);
    put_in_order(some.log);
    const fs::path path = this->folder.path() / fmt::format("{}.maps", index);
    for (std::size_t k = 0; k < whole.maps.size(); ++k) some.segments[k].is_map = k % count == index;
    auto writer = StoreWriter<kDim>::open(path, some.log, some.segments, some.options, {index, count});
    for (const std::size_t k : std::vector<std::size_t>(writer->to_do().begin(), writer->to_do().end())) {
      EXPECT_TRUE(writer->add(k, whole.maps[k]));
    }
    EXPECT_TRUE(writer->finish());
    return path;
  }

  StoredMaps<kDim> whole = testing::random_stored_maps<kDim>(this->random, 7);
};

TYPED_TEST_SUITE(PortionTest, testing::Dimensions);

TYPED_TEST(PortionTest, AllTogetherAreTheLog) {
  constexpr int kDim = TestFixture::kDim;
  const auto merged = open_several_maps({this->build(2, 3), this->build(0, 3), this->build(1, 3)});
  ASSERT_TRUE(merged) << merged.error().message;
  const auto& joined = std::get<StoredMaps<kDim>>(*merged);
  EXPECT_EQ(joined.segments, this->whole.segments);
  EXPECT_TRUE(testing::same(joined.maps, this->whole.maps));
  EXPECT_TRUE(joined.portion.is_whole());
  EXPECT_EQ(joined.log.poses, this->whole.log.poses);
  EXPECT_TRUE(testing::same(joined.log.graph.pose_factors, this->whole.log.graph.pose_factors));
  EXPECT_TRUE(testing::same(joined.log.graph.feature_factors, this->whole.log.graph.feature_factors));
}

TYPED_TEST(PortionTest, SomeAloneAreNot) {
  const fs::path first = this->build(0, 3);
  EXPECT_THAT(open_several_maps({first}).error().message, HasSubstr("the store has portion 1 of 3 of its log"));
  EXPECT_THAT(open_several_maps({first, this->build(1, 3)}).error().message,
              HasSubstr("its 3 portions are to be joined together, each once; there are 2 stores"));
  EXPECT_THAT(open_several_maps({first, first, first}).error().message, HasSubstr("there are 3 stores"));
}

TYPED_TEST(PortionTest, IsOneOfSoMany) {
  const fs::path store = this->build(1, 3);
  for (const char* wrong : {"0/3", "4/3", "2/3x", "2", "2/", "x", "1/1", "-1/3"}) {
    execute_sql(store, fmt::format("UPDATE info SET value = '{}' WHERE key = 'portion'", wrong));
    ASSERT_TRUE(seal(store));
    const auto read = read_store(store);
    ASSERT_FALSE(read) << wrong;
    EXPECT_THAT(read.error().message, HasSubstr("damaged store: info portion makes no sense")) << wrong;
  }
}

TYPED_TEST(PortionTest, IsNotGoneOnWithAsAnother) {
  constexpr int kDim = TestFixture::kDim;
  const auto done = [&](const Portion& portion) {
    return StoreWriter<kDim>::open(this->path, this->whole.log, this->whole.segments, "", portion)->done().size();
  };
  {
    auto writer = StoreWriter<kDim>::open(this->path, this->whole.log, this->whole.segments, "", {1, 3});
    for (const std::size_t k : {0U, 1U, 2U, 3U, 4U, 5U, 6U}) ASSERT_TRUE(writer->add(k, this->whole.maps[k]));
    ASSERT_TRUE(writer->finish());
    fs::rename(this->path, this->partial);
  }
  EXPECT_EQ(done({1, 3}), 7U);
  EXPECT_EQ(done({2, 3}), 0U);
}

TYPED_TEST(PortionTest, PiecesAreWhatTheStoreHas) {
  constexpr int kDim = TestFixture::kDim;
  build_store(this->path, this->whole);
  auto pieces = StorePieces::open(this->path);
  ASSERT_TRUE(pieces);
  const store::Contents<kDim> contents{this->whole.log, this->whole.segments, this->whole.options};
  EXPECT_TRUE(*pieces->holds(contents));
  EXPECT_FALSE(*pieces->holds(store::Contents<kDim>{this->whole.log, this->whole.segments, "others"}));
  std::vector<Segment> some = this->whole.segments;
  some[0].is_map = some[5].is_map = false;
  const auto maps = pieces->maps(this->whole.log, some);
  ASSERT_TRUE(maps) << maps.error().message;
  ASSERT_EQ(maps->size(), 5U);
  EXPECT_TRUE(testing::same(*maps->front(), this->whole.maps[1]));
  EXPECT_TRUE(testing::same(*maps->back(), this->whole.maps[6]));
}

TYPED_TEST(PortionTest, PiecesThatAreDamagedAreRefused) {
  build_store(this->path, this->whole);
  const auto maps = [&](const char* sql) {
    execute_sql(this->path, sql);
    return StorePieces::open(this->path)->maps(this->whole.log, this->whole.segments);
  };
  EXPECT_FALSE(maps("UPDATE maps SET base = NULL WHERE segment = 2")->at(2)) << "it did not determine a map";
  EXPECT_THAT(maps("UPDATE maps SET information = x'00' WHERE segment = 5").error().message,
              HasSubstr("damaged store: the local map of pose a10 of session 7 to pose a12 of session 7 makes no sense"));
  EXPECT_THAT(
      maps("DELETE FROM maps WHERE segment = 4").error().message,
      HasSubstr("unfinished store: the local map of segment 4 is missing; the same `mapjoin build` again goes on from there"));
}

}  // namespace
}  // namespace mapjoin
