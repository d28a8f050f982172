// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ConvertTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  double chi2(const std::string& command, const std::string& input) const {
    return report_of({command, input, "-o", path("map.csv")})["chi2"];
  }

  const std::string town = kBundledLog;
  TemporaryFolder folder;
};

TEST_F(ConvertTest, TakesTheFormatFromTheNameOrAsItIsTold) {
  for (const char* name : {"log.g2o", "log.isam", "log.gtsam", "log.txt", "log.mat"}) {
    const Ended ended = call({"convert", town, path(name)});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_NEAR(chi2("solve", path(name)), 4702.179445, 1e-5) << name;
  }
  ASSERT_EQ(call({"convert", town, path("log.dat"), "--to", "isam"}).exit_code, 0);
  EXPECT_EQ(content_of(path("log.dat")), content_of(path("log.isam")));
}

TEST_F(ConvertTest, SaysWhatIsLost) {
  const Ended isam = call({"convert", town, path("log.isam")});
  EXPECT_THAT(isam.out, HasSubstr("lost         which poses are fixed is left out\n"));
  EXPECT_THAT(isam.out, Not(HasSubstr("values")));  // the log has none
  const Ended toro = call({"convert", town, path("log.graph")});
  EXPECT_THAT(toro.out, HasSubstr("143 features with 2524 observations left out"));
  EXPECT_THAT(toro.out, HasSubstr("poses are where odometry alone has them"));
  EXPECT_THAT(call({"convert", town, path("log.g2o")}).out, Not(HasSubstr("lost")));
  EXPECT_THAT(call({"convert", town, path("log.isam"), "--quiet"}).out, IsEmpty());
}

TEST_F(ConvertTest, BringsAG2oFileBackToTheByte) {
  ASSERT_EQ(call({"convert", town, path("log.g2o")}).exit_code, 0);
  EXPECT_EQ(content_of(path("log.g2o")), content_of(town));
}

TEST_F(ConvertTest, WritesStoredLocalMapsAsTheAuthorsDidAndTheirLog) {
  ASSERT_EQ(call({"build", town, "-o", path("maps"), "--poses-per-map", "50"}).exit_code, 0);
  const double of_store = report_of({"join", path("maps"), "-o", path("map.csv"), "--no-polish"})["join"]["chi2"];
  for (const char* format : {"maps-text", "maps-mat"}) {
    const Ended ended = call({"convert", path("maps"), path(format), "--to", format});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("the log that the maps were built from is left out"));
    EXPECT_NEAR(chi2("join", path(format)), of_store, 1e-6 * of_store);
  }
  ASSERT_EQ(call({"convert", path("maps-text"), path("again"), "--to", "store"}).exit_code, 0);
  EXPECT_NEAR(chi2("join", path("again")), of_store, 1e-6 * of_store);
  ASSERT_EQ(call({"convert", path("maps"), path("log.g2o")}).exit_code, 0);
  EXPECT_NEAR(chi2("solve", path("log.g2o")), 4702.179445, 1e-5);
}

TEST_F(ConvertTest, LocalMapsGetAFolderOfTheirOwn) {
  for (const std::string length : {"50", "100"}) {
    ASSERT_EQ(call({"build", town, "-o", path(length), "--poses-per-map", length}).exit_code, 0);
  }
  std::filesystem::create_directory(path("set"));
  ASSERT_EQ(call({"convert", path("50"), path("set") + "/", "--to", "maps-text"}).exit_code, 0);
  const Ended second = call({"convert", path("100"), path("set"), "--to", "maps-text"});
  EXPECT_EQ(second.exit_code, 5);
  EXPECT_EQ(second.err, "mapjoin: " + path("set") + ": Directory not empty\n");
  EXPECT_EQ(report_of({"join", path("set"), "-o", path("map.csv")})["local_maps"]["count"], 20);
}

TEST_F(ConvertTest, RefusesWhatCannotBe) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& why) {
    std::vector<std::string> all{"convert"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Ended ended = call(all);
    EXPECT_EQ(ended.exit_code, 2) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(why));
  };
  refused({town, path("log")}, "its name does not say which format it is to have");
  refused({town, path("maps"), "--to", "maps-text"}, "local maps of a log are made by `mapjoin build`");
  refused({town, path("log"), "--to", "pdf"}, "not one of g2o|toro");
  refused({(kBundledData / "manhattan3d.g2o").string(), path("log.mat")}, "the format mat is for the plane");
  refused({town, town}, "IN and OUT are one file");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_EQ(call({"convert", path("missing"), path("log.g2o")}).exit_code, 3);
  EXPECT_EQ(call({"convert", town, path("no/such/log.g2o")}).exit_code, 5);
}

TEST_F(ConvertTest, SegmentsThatAreNoLocalMapsAreCounted) {
  const std::string log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n").string();
  for (const auto& [length, said] : {std::pair("2", "1 of its 2 segments is not a local map, but"),
                                     std::pair("1", "3 of its 3 segments are not local maps, but")}) {
    ASSERT_EQ(call({"build", log, "-o", path(length), "--poses-per-map", length}).exit_code, 0);
    expect_failure(call({"convert", path(length), path("set"), "--to", "maps-mat"}), 2, said);
  }
}

TEST_F(ConvertTest, ClosuresInsideOfSegmentsAreNamedWhereAnotherCutWouldNotHelp) {
  std::string text;
  for (int k = 0; k < 8; ++k) text += "EDGE_SE2 " + std::to_string(k) + ' ' + std::to_string(k + 1) + " 1 0 0 1 0 0 1 0 1\n";
  for (int k = 2; k < 9; ++k) text += "EDGE_SE2 " + std::to_string(k) + " 0 0 0 0 1 0 0 1 0 1\n";
  const std::string log = folder.file("log.g2o", text).string();
  ASSERT_EQ(call({"build", log, "-o", path("maps"), "--poses-per-map", "4"}).exit_code, 0);
  expect_failure(
      call({"convert", path("maps"), path("set"), "--to", "maps-text"}), 2,
      "but observations, since closures lead to poses inside of them: these files have place for the ends of maps only");
}

TEST_F(ConvertTest, AFolderThatIsThereKeepsItsPermissions) {
  ASSERT_EQ(call({"build", town, "-o", path("maps"), "--quiet"}).exit_code, 0);
  std::filesystem::create_directory(path("set"));
  const auto of_owner = std::filesystem::perms::owner_all;
  std::filesystem::permissions(path("set"), of_owner);
  ASSERT_EQ(call({"convert", path("maps"), path("set"), "--to", "maps-text"}).exit_code, 0);
  EXPECT_EQ(std::filesystem::status(path("set")).permissions(), of_owner);
}

TEST_F(ConvertTest, TrajectoriesAreTruthInEitherFormat) {
  const std::string truth = kBundledTruth;
  ASSERT_EQ(call({"convert", truth, path("truth.kitti")}).exit_code, 0);
  const auto nees = [&](const std::string& file) {
    return report_of({"run", town, "-o", path("out"), "--truth", file})["certainty"]["nees"]["poses"]["value"].get<double>();
  };
  EXPECT_NEAR(nees(truth), nees(path("truth.kitti")), 1e-3);
}

}  // namespace
}  // namespace mapjoin::testing
