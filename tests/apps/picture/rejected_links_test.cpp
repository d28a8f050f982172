// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <apps/exit_code.hpp>
#include <apps/picture/links.hpp>
#include <apps/report/verdict.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::apps {
namespace {

using ::testing::HasSubstr;

/// A run over two sessions and a feature whose key is that of a pose, so that a g2o file has other names for them.
class RejectedLinksTest : public ::testing::Test {
 protected:
  RejectedLinksTest() {
    map_.pose_ids = {{0, 3}, {0, 4}, {1, 3}, {1, 4}};
    map_.poses.resize(4);
    map_.feature_ids = {{4}};
    map_.features = {Point<2>(1.0, 2.0)};
    EXPECT_TRUE(write_csv(map_, folder_.path() / "poses.csv", folder_.path() / "features.csv"));
    EXPECT_TRUE(write_g2o<2>(map_, nullptr, folder_.path() / "map.g2o"));
  }
  /// The links of a `rejected.csv` with these lines.
  std::vector<Link> links(const std::string& lines) const {
    folder_.file("rejected.csv", "kind,from,to,chi2,probability,why,from_session,to_session\n" + lines);
    const auto log = std::get<Log<2>>(open_log(folder_.path()).value());
    std::vector<Link> links;
    add_rejected_links(folder_.path() / "rejected.csv", log.poses, log.features, links);
    return links;
  }
  std::string error(const std::string& lines) const {
    try {
      links(lines);
    } catch (const tl::bad_expected_access<Error>& failed) {
      EXPECT_EQ(failed.error().kind, ErrorKind::kBadInput);
      return failed.error().message;
    }
    return "";
  }

  testing::TemporaryFolder folder_;
  GlobalMap<2> map_;
};

TEST_F(RejectedLinksTest, OfAFolderAreFoundUnderTheNamesOfTheLog) {
  ASSERT_NE(std::get<Log<2>>(open_log(folder_.path() / "map.g2o").value()).features, map_.feature_ids);
  const std::vector<Link> found =
      links("closure,4,3,99,0,contradicted,0,1\nobservation,4,4,12.5,1e-300,crowded,1,\nodometry,3,4,50,0,contradicted,0,0\n");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].from, PoseIndex(1));
  EXPECT_EQ(found[0].to, PoseOrFeature(PoseIndex(2)));
  EXPECT_EQ(found[1].from, PoseIndex(3));
  EXPECT_EQ(found[1].to, PoseOrFeature(FeatureIndex(0)));
  EXPECT_EQ(found[2].to, PoseOrFeature(PoseIndex(1)));
  for (const Link& link : found) EXPECT_TRUE(link.is_rejected);
}

TEST_F(RejectedLinksTest, FixesAreNone) {
  EXPECT_TRUE(links("fix,7,4,99,0,contradicted,,1\n").empty());
}

TEST_F(RejectedLinksTest, OfAnEmptyTableAreNone) {
  EXPECT_TRUE(links("").empty());
}

TEST_F(RejectedLinksTest, OfAnotherMapAreRefused) {
  EXPECT_THAT(error("closure,4,9,99,0,contradicted,0,1\n"), HasSubstr("rejected.csv: is not of the map beside it"));
  EXPECT_THAT(error("closure,four,3,99,0,contradicted,0,1\n"), HasSubstr("rejected.csv"));
  map_.pose_ids = {{0, 3}, {0, 5}, {1, 3}, {1, 4}};
  ASSERT_TRUE(write_csv(map_, folder_.path() / "poses.csv", folder_.path() / "features.csv"));
  EXPECT_THAT(error("closure,5,3,99,0,contradicted,0,1\n"), HasSubstr("is not of the map beside it"));
}

TEST_F(RejectedLinksTest, OfARunAreThoseOfItsReport) {
  RunReport run_report("run", Options{});
  run_report.rejected.resize(1);
  run_report.rejected[0].misfit.from = 2;
  run_report.rejected[0].misfit.to = FeatureIndex(0);
  std::vector<Link> links;
  add_rejected_links(run_report, links);
  ASSERT_EQ(links.size(), 1U);
  EXPECT_TRUE(links[0].is_rejected);
  EXPECT_EQ(links[0].from, PoseIndex(2));
  EXPECT_EQ(links[0].to, PoseOrFeature(FeatureIndex(0)));
}

}  // namespace
}  // namespace mapjoin::apps
