// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <tests/support/data.hpp>
#include <tests/support/dimensions.hpp>
#include <tests/support/error_of.hpp>
#include <tests/support/random.hpp>
#include <tests/support/same_log.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename Dimension>
class LocalMapWriterTest : public ::testing::Test {
 protected:
  static constexpr int kDim = Dimension::value;

  /// A local map from pose k to pose k + 1, with two features.
  LocalMap<kDim> map(PoseIndex k) {
    LocalMap<kDim> map;
    map.base = k;
    map.poses = {k + 1};
    map.features = {FeatureIndex(k.value), 2};
    map.pose_estimates = {random.template pose<kDim>(5.0, 0.8)};
    for (int f = 0; f < 2; ++f) map.feature_estimates.push_back(random.template vector<kDim>(9.0));
    const Eigen::Index n = map.row(3);
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(n, n);
    map.information = A * A.transpose() + Eigen::MatrixXd::Identity(n, n);
    map.information = (0.5 * (map.information + map.information.transpose())).eval();
    return map;
  }
  /// The maps, over the features `features`, written and read back.
  SubmapSet<kDim> again(const std::vector<LocalMap<kDim>>& maps, LocalMapFormat format) {
    names = write_local_maps(maps, features, format, folder.path()).value();
    return std::get<SubmapSet<kDim>>(read_local_map_set(folder.path()).value());
  }
  std::string refusal(const std::vector<LocalMap<kDim>>& maps, LocalMapFormat format) {
    return testing::error_of(write_local_maps(maps, features, format, folder.path()));
  }
  static void expect_same(const std::vector<LocalMap<kDim>>& a, const std::vector<LocalMap<kDim>>& b, double tolerance) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t m = 0; m < a.size(); ++m) {
      EXPECT_EQ(a[m].poses, b[m].poses);
      EXPECT_EQ(a[m].features, b[m].features);
      expect_same_value(a[m].pose_estimates[0], b[m].pose_estimates[0], tolerance);
      for (std::size_t f = 0; f < 2; ++f) expect_same_value(a[m].feature_estimates[f], b[m].feature_estimates[f], 0.0);
      expect_same_matrix(a[m].information, b[m].information, tolerance * a[m].information.norm());
    }
  }

  Random random;
  FeatureIds features{{0}, {7}, {900}};
  std::vector<std::string> names;
  TemporaryFolder folder;
};
TYPED_TEST_SUITE(LocalMapWriterTest, Dimensions);

TYPED_TEST(LocalMapWriterTest, WritesTextThatReadsBackAsTheSameMaps) {
  constexpr int Dim = TypeParam::value;
  const std::vector<LocalMap<Dim>> maps{this->map(0), this->map(1)};
  const auto again = this->again(maps, LocalMapFormat::kText);
  EXPECT_THAT(this->names, ElementsAre("localmap_1.txt", "localmap_2.txt"));
  EXPECT_EQ(again.features, this->features);
  this->expect_same(maps, again.graph.submaps, Dim == 2 ? 0.0 : 1e-12);
}

TYPED_TEST(LocalMapWriterTest, WritesMatFilesThatReadBackAsTheSameMapsToRounding) {
  constexpr int Dim = TypeParam::value;
  const std::vector<LocalMap<Dim>> maps{this->map(0), this->map(1)};
  this->expect_same(maps, this->again(maps, LocalMapFormat::kMat).graph.submaps, 1e-11);
  EXPECT_THAT(this->names, ElementsAre("localmap_1.mat", "localmap_2.mat"));
}

TYPED_TEST(LocalMapWriterTest, RefusesInASentenceWhatTheFilesCannotSay) {
  constexpr int Dim = TypeParam::value;
  const LocalMap<Dim> map = this->map(0);
  EXPECT_EQ(this->refusal({map, map}, LocalMapFormat::kText),
            "local map 2 does not start where the one before it ends, which such files cannot say");
  auto inner = map;
  inner.poses = {1, 2};
  EXPECT_THAT(this->refusal({inner}, LocalMapFormat::kText), HasSubstr("local map 1 keeps inner poses"));
  this->features[2].key = std::uint64_t{1} << 53;
  EXPECT_THAT(this->refusal({map}, LocalMapFormat::kMat), HasSubstr("whose id is 2^53 or more"));
  this->features[2].key = 900;
  if (Dim == 2) {
    auto singular = map;
    singular.information.setZero();
    EXPECT_THAT(this->refusal({singular}, LocalMapFormat::kMat), HasSubstr("singular"));
  }
}

TEST(LocalMapWriterData, PublicSetsComeBackMapsThatDoNotMoveAmongThem) {
  for (const auto& [name, format, tolerance] : {std::tuple{"vicpark-200-local-maps", LocalMapFormat::kText, 0.0},
                                                {"vicpark-200-local-maps", LocalMapFormat::kMat, 1e-11},
                                                {"dlr/localmaps_3298_mat.tar.gz", LocalMapFormat::kMat, 1e-11}}) {
    const TemporaryFolder folder;
    const auto set = std::get<SubmapSet<2>>(read_local_map_set(data_file(name)).value());
    ASSERT_TRUE(write_local_maps(set.graph.submaps, set.features, format, folder.path()));
    const auto again = std::get<SubmapSet<2>>(read_local_map_set(folder.path()).value());
    EXPECT_EQ(again.poses, set.poses);
    EXPECT_EQ(again.features, set.features);
    ASSERT_EQ(again.graph.submaps.size(), set.graph.submaps.size());
    for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
      EXPECT_EQ(again.graph.submaps[m].base, set.graph.submaps[m].base);
      EXPECT_EQ(again.graph.submaps[m].poses, set.graph.submaps[m].poses);
      expect_same_matrix(set.graph.submaps[m].information, again.graph.submaps[m].information,
                         tolerance * set.graph.submaps[m].information.norm());
    }
  }
}

}  // namespace
}  // namespace mapjoin::testing
