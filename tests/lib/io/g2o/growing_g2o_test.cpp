// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <mapjoin/io/g2o/growing_g2o.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

using ::testing::HasSubstr;

class GrowingG2oTest : public ::testing::Test {
 protected:
  GrowingG2oTest() { append(""); }

  void append(const std::string& text) const { std::ofstream(path_, std::ios::app) << text; }
  GrowingG2o open() const { return GrowingG2o::open(path_, {}).value(); }

  /// The number of edges and observations that have come.
  static std::size_t count(const Expected<std::optional<AnyLog>>& news) {
    if (!news.value()) return 0;
    const auto count_in = [](const auto& log) { return log.edges().size() + log.observations().size(); };
    return std::visit(count_in, **news);
  }

  const std::string kEdge01 = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  const std::string kEdge12 = "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n";
  testing::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "log.g2o";
};

TEST_F(GrowingG2oTest, GivesWhatHasComeInWholeLines) {
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 0u);
  append(kEdge01 + kEdge12.substr(0, 10));
  EXPECT_EQ(count(file.appended()), 1u);
  EXPECT_EQ(count(file.appended()), 0u);
  append(kEdge12.substr(10) + "EDGE_SE2_XY 1 7 2 1 1 0 1\n");
  EXPECT_EQ(count(file.appended()), 2u);
  append("EDGE_SE2_XY 2 7 1 1 1 0 1");
  EXPECT_EQ(count(file.appended()), 0u);
  EXPECT_EQ(count(file.rest()), 1u);
  EXPECT_EQ(std::get<Log<2>>(file.whole().value()).observations().size(), 2u);
}

TEST_F(GrowingG2oTest, SoFarAreThePosesThatEdgesName) {
  GrowingG2o file = open();
  append("FIX 0 9\nVERTEX_SE2 0 5 0 0\nVERTEX_SE2 8 5 0 0\nVERTEX_XY 9 5 0\n" + kEdge01);
  EXPECT_EQ(count(file.appended()), 1u);
  EXPECT_FALSE(file.whole());
  const auto so_far = std::get<Log<2>>(file.so_far().value());
  EXPECT_EQ(so_far.poses, (PoseIds{{0, 0}, {0, 1}}));
  EXPECT_TRUE(so_far.features.empty());
  ASSERT_EQ(so_far.graph.fixed.size(), 1u);
  EXPECT_EQ(so_far.graph.fixed[0].value.translation.x(), 5.0);
}

TEST_F(GrowingG2oTest, VerticesAndFixedPosesMayComeBeforeOrAfterTheirEdges) {
  GrowingG2o file = open();
  append("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nFIX 0\n");
  EXPECT_EQ(count(file.appended()), 0u);
  append(kEdge01);
  EXPECT_EQ(count(file.appended()), 1u);
  append("VERTEX_SE2 2 2 0 0\n" + kEdge12);
  EXPECT_EQ(count(file.appended()), 1u);
  const auto whole = std::get<Log<2>>(file.whole().value());
  EXPECT_EQ(whole.graph.fixed.size(), 1u);
  EXPECT_EQ(whole.initial.poses.size(), 3u);
}

TEST_F(GrowingG2oTest, WhatStandsBehindTheLastEdgeIsOfTheWhole) {
  append(kEdge01);
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 1u);
  append("FIX 1\n");
  EXPECT_EQ(count(file.appended()), 0u);
  EXPECT_EQ(count(file.rest()), 0u);
  EXPECT_EQ(std::get<Log<2>>(file.whole().value()).graph.fixed.size(), 1u);
}

TEST_F(GrowingG2oTest, LinesThatNameNoPoseWaitForOneThatDoes) {
  auto file = GrowingG2o::open(path_, {.skip_unknown = true, .skip_self_edges = true}).value();
  for (const std::string line :
       {"EDGE_SE2_MIXTURE 0 1 1\n", "EDGE_PRIOR_XY 7 1 1 1 0 1\n", "EDGE_SE2 1 1 0 0 0 1 0 0 1 0 1\n"}) {
    append(line);
    EXPECT_EQ(count(file.appended()), 0u) << line;
    append(line + kEdge01);
    EXPECT_EQ(count(file.appended()), 1u) << line;
  }
  append("EDGE_PRIOR_XY 7 1 1 1 0 1\n");
  EXPECT_EQ(count(file.appended()), 0u);
  EXPECT_EQ(count(file.rest()), 0u);
  const auto whole = std::get<Log<2>>(file.whole().value());
  EXPECT_EQ(whole.feature_priors().size(), 3u);
  EXPECT_EQ(whole.skipped, (SkipCounts{{"EDGE_SE2_MIXTURE lines", 2}, {"self-edges", 2}}));
}

TEST_F(GrowingG2oTest, NamesTheLineThatIsWrongBehindTheLastEdge) {
  append(kEdge01);
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 1u);
  append("FIX one\n");
  EXPECT_EQ(count(file.appended()), 0u);
  EXPECT_THAT(file.rest().error().message, HasSubstr("log.g2o:2:5: 'one' stands where an id is expected"));
  EXPECT_EQ(std::get<Log<2>>(file.whole().value()).odometry().size(), 1u);
}

TEST_F(GrowingG2oTest, ASensorOffsetIsHeededByLaterObservations) {
  append("PARAMS_SE3OFFSET 4 0 0 5 0 0 0 1\nEDGE_SE3_TRACKXYZ 0 7 4 1 2 3 1 0 0 1 0 1\n");
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 1u);
  append("EDGE_SE3_TRACKXYZ 0 8 4 1 2 3 1 0 0 1 0 1\n");
  const auto news = file.appended().value();
  EXPECT_EQ(std::get<Log<3>>(*news).observations()[0].measured.z(), 8.0);
}

TEST_F(GrowingG2oTest, NamesTheLineThatIsWrongAndGivesWhatStandsBefore) {
  append("# a comment\n" + kEdge01);
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 1u);
  append(kEdge12 + "EDGE_SE2 2 3 1 0 zero 1 0 0 1 0 1\n" + kEdge01);
  EXPECT_EQ(count(file.appended()), 1u);
  for (int times = 0; times < 2; ++times) {
    const auto fault = file.appended();
    ASSERT_FALSE(fault);
    EXPECT_THAT(fault.error().message, HasSubstr("log.g2o:4:18: "));
  }
  EXPECT_EQ(std::get<Log<2>>(file.whole().value()).odometry().size(), 2u);
}

TEST_F(GrowingG2oTest, WhatIsWrongFromTheStartGivesNothing) {
  append("EDGE_SE2 0 1 1 0\n" + kEdge12);
  GrowingG2o file = open();
  EXPECT_THAT(file.appended().error().message, HasSubstr("log.g2o:1:"));
}

TEST_F(GrowingG2oTest, WhatCannotBeFollowedIsRefused) {
  EXPECT_FALSE(GrowingG2o::open(folder_.path() / "none", {}));
  EXPECT_THAT(GrowingG2o::open(folder_.path(), {}).error().message, HasSubstr("plain file"));
  const auto pipe = folder_.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(GrowingG2o::open(pipe, {}).error().message, HasSubstr("plain file")) << "without waiting for its writer";
  append("\x1f\x8b" + kEdge01);
  GrowingG2o zipped = open();
  EXPECT_THAT(zipped.appended().error().message, HasSubstr("gzip"));
}

TEST_F(GrowingG2oTest, AFileThatIsCutIsNoticed) {
  append(kEdge01 + kEdge12);
  GrowingG2o file = open();
  EXPECT_EQ(count(file.appended()), 2u);
  std::filesystem::resize_file(path_, 10);
  EXPECT_THAT(file.appended().error().message, HasSubstr("cut"));
}

TEST_F(GrowingG2oTest, SaysThatItsNameIsAnotherFilesOnceAllThatWasInItIsGiven) {
  namespace fs = std::filesystem;
  const auto follow_while = [&](const auto& change) {
    fs::remove(path_);
    append(kEdge01);
    GrowingG2o file = open();
    EXPECT_EQ(count(file.appended()), 1u);
    append(kEdge12);
    change();
    EXPECT_EQ(count(file.appended()), 1u) << "of the file that was opened";
    const auto after = file.appended();
    return after ? "no error" : after.error().message;
  };
  const auto replaced = HasSubstr("log.g2o: the file was replaced, renamed or removed while it was followed");
  EXPECT_EQ(follow_while([] {}), "no error");
  EXPECT_THAT(follow_while([&] { fs::rename(folder_.file("other", kEdge01), path_); }), replaced);
  EXPECT_THAT(follow_while([&] { fs::remove(path_); }), replaced);
  EXPECT_THAT(follow_while([&] {
                fs::remove(path_);
                append(kEdge01);
              }),
              replaced);
}

}  // namespace
}  // namespace mapjoin
