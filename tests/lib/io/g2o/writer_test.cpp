// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <stdexcept>
#include <string>
#include <tests/support/dimensions.hpp>
#include <tests/support/random.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

template <typename D>
class G2oWriterTest : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;

  /// Odometry, a closure and observations over three poses and two features named apart from them.
  LogBuilder<kDim> some_log(bool with_vertices) {
    LogBuilder<kDim> builder("some.log");
    for (std::uint64_t i = 0; i < 3; ++i) {
      if (with_vertices) builder.add_pose({0, i}, random.template pose<kDim>());
      builder.add_pose_edge({0, i}, {0, (i + 1) % 3}, random.template pose<kDim>(),
                            random.template information<kPoseDof<kDim>>());
      builder.add_observation({0, i}, {10 + i % 2}, random.template vector<kDim>(), random.template information<kDim>());
    }
    for (std::uint64_t f = 10; with_vertices && f < 12; ++f) builder.add_feature({f}, random.template vector<kDim>());
    return builder;
  }
  static Log<kDim> finish(LogBuilder<kDim> builder) { return std::move(builder).finish().value(); }

  template <typename... Args>
  std::string written(Args&&... args) {
    const auto done = write_g2o<kDim>(std::forward<Args>(args)..., path);
    if (!done) return done.error().message;
    return testing::content_of(path);
  }
  Log<kDim> read(const std::string& text) { return std::get<Log<kDim>>(read_g2o(TextScanner("some.g2o", text), {}).value()); }

  testing::Random random;
  testing::TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "some.g2o";
};
TYPED_TEST_SUITE(G2oWriterTest, testing::Dimensions);

TYPED_TEST(G2oWriterTest, BringsBackEveryBitOfALog) {
  for (const bool with_vertices : {false, true}) {
    const auto log = this->finish(this->some_log(with_vertices));
    const auto again = this->read(this->written(log));
    ASSERT_EQ(again.odometry().size(), 2u);
    ASSERT_EQ(again.closures().size(), 1u);
    ASSERT_EQ(again.observations().size(), 3u);
    testing::expect_same_log(log, again);
    ASSERT_EQ(again.initial.poses.size(), log.initial.poses.size());
    for (const PoseIndex p : indices(log.initial.poses)) {
      testing::expect_same_value(log.initial.poses[p], again.initial.poses[p], 0.0);
    }
    EXPECT_EQ(again.initial.features, log.initial.features);
  }
}

TYPED_TEST(G2oWriterTest, WritesFixedPosesWhereTheyAreFixed) {
  constexpr int kDim = TestFixture::kDim;
  auto builder = this->some_log(true);
  const auto place = this->random.template pose<kDim>();
  builder.fix({0, 1}, place);
  const auto again = this->read(this->written(this->finish(builder)));
  ASSERT_EQ(again.graph.fixed.size(), 1u);
  EXPECT_EQ(again.graph.fixed[0].value.translation, place.translation);
}

TYPED_TEST(G2oWriterTest, SaysWhatG2oFilesCannotHold) {
  constexpr int kDim = TestFixture::kDim;
  auto fixed = this->some_log(false);
  fixed.fix({0, 0});
  EXPECT_THAT(this->written(this->finish(fixed)), HasSubstr("FIX 0\n"));
  fixed.fix({0, 1}, this->random.template pose<kDim>());
  EXPECT_THAT(this->written(this->finish(fixed)), HasSubstr("cannot fix pose 1 away from the origin"));
}

TYPED_TEST(G2oWriterTest, BringsBackPriorsBitByBit) {
  constexpr int kDim = TestFixture::kDim;
  auto builder = this->some_log(true);
  const PoseMatrix<kDim> W = this->random.template information<kPoseDof<kDim>>();
  builder.add_pose_prior({0, 0}, this->random.template pose<kDim>(), W);
  PoseMatrix<kDim> position = W;
  position.template rightCols<kRotationDof<kDim>>().setZero();
  position.template bottomRows<kRotationDof<kDim>>().setZero();
  builder.add_pose_prior({0, 1}, {Point<kDim>::Ones(), {}}, position);
  builder.add_feature_prior({10}, Point<kDim>::Ones(), W.template topLeftCorner<kDim, kDim>());
  const auto log = this->finish(builder);
  const auto again = this->read(this->written(log));
  ASSERT_EQ(again.pose_priors().size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(again.pose_priors()[k].target, log.pose_priors()[k].target);
    EXPECT_EQ(again.pose_priors()[k].measured.translation, log.pose_priors()[k].measured.translation);
    EXPECT_EQ(again.pose_priors()[k].measured.rotation.matrix(), log.pose_priors()[k].measured.rotation.matrix());
    EXPECT_EQ(again.pose_priors()[k].information, log.pose_priors()[k].information);
  }
  ASSERT_EQ(again.feature_priors().size(), 1u);
  EXPECT_EQ(again.feature_priors()[0].target, log.feature_priors()[0].target);
  EXPECT_EQ(again.feature_priors()[0].information, log.feature_priors()[0].information);
}

TYPED_TEST(G2oWriterTest, NumbersSessionsAndFeaturesApartByPowersOfTen) {
  constexpr int kDim = TestFixture::kDim;
  LogBuilder<kDim> builder("some.log");
  builder.add_pose_edge({0, 1}, {0, 12}, {}, PoseMatrix<kDim>::Identity());
  builder.add_pose_edge({2, 1}, {2, 12}, {}, PoseMatrix<kDim>::Identity());
  builder.add_observation({2, 12}, {1}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  const auto text = this->written(this->finish(builder));
  const auto log = this->read(text);
  EXPECT_THAT(log.poses, ::testing::ElementsAre(PoseId{0, 1}, PoseId{0, 12}, PoseId{0, 201}, PoseId{0, 212}));
  EXPECT_EQ(log.features.at(0).key, 1001u);
  EXPECT_EQ(log.observations()[0].base, PoseIndex(3));
}

TYPED_TEST(G2oWriterTest, LeavesKeysOfSessionsThatDoNotMeetAndTheLettersOfSymbols) {
  constexpr int kDim = TestFixture::kDim;
  const auto symbol = [](char letter, std::uint64_t index) { return (static_cast<std::uint64_t>(letter) << 56) + index; };
  const auto ids_again = [&](PoseId first, PoseId second) {
    LogBuilder<kDim> builder("some.log");
    builder.add_pose_edge(first, second, {}, PoseMatrix<kDim>::Identity());
    return this->read(this->written(this->finish(builder))).poses;
  };
  EXPECT_THAT(ids_again({0, symbol('a', 7)}, {1, symbol('b', 7)}),
              ::testing::ElementsAre(PoseId{0, symbol('a', 7)}, PoseId{0, symbol('b', 7)}));
  EXPECT_THAT(ids_again({0, symbol('x', 7)}, {2, symbol('x', 7)}),
              ::testing::ElementsAre(PoseId{0, symbol('x', 7)}, PoseId{0, symbol('x', 27)}));
}

TYPED_TEST(G2oWriterTest, RefusesKeysThatLeaveNoRoom) {
  constexpr int kDim = TestFixture::kDim;
  LogBuilder<kDim> builder("some.log");
  builder.add_observation({0, ~std::uint64_t{0}}, {~std::uint64_t{0}}, Point<kDim>::Ones(), PointMatrix<kDim>::Identity());
  EXPECT_THAT(this->written(this->finish(builder)), HasSubstr("one numbering of 64 bits"));
}

TYPED_TEST(G2oWriterTest, WritesAGlobalMapWithItsGaugeAndTheEdgesOfItsLog) {
  constexpr int kDim = TestFixture::kDim;
  const auto log = this->finish(this->some_log(false));
  GlobalMap<kDim> map;
  map.pose_ids = log.poses;
  map.feature_ids = log.features;
  for (int i = 0; i < 3; ++i) map.poses.push_back(this->random.template pose<kDim>());
  for (int i = 0; i < 2; ++i) map.features.push_back(this->random.template vector<kDim>());
  map.gauge = {0};

  const auto without_edges = this->written(map, nullptr);
  EXPECT_THAT(without_edges, Not(HasSubstr("EDGE")));
  const auto again = this->read(this->written(map, &log));
  EXPECT_EQ(again.initial.features, map.features);
  EXPECT_EQ(again.initial.poses.at(2).translation, map.poses[2].translation);
  EXPECT_EQ(again.graph.fixed.at(0).value.translation, map.poses[0].translation);
  EXPECT_EQ(again.odometry().size() + again.closures().size() + again.observations().size(), 6u);

  map.feature_ids.pop_back();
  EXPECT_THROW((void)write_g2o<kDim>(map, &log, this->path), std::invalid_argument);
}

}  // namespace
}  // namespace mapjoin
