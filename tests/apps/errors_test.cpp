// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <mapjoin/io/store/store.hpp>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class BadInput : public ::testing::Test {
 protected:
  /// Expects a log with this content to be refused, with a message that has its name followed by `place`, and `part`.
  void expect_refused(const std::string& content, const std::string& place, const std::string& part) const {
    const auto log = folder.file("log.g2o", content);
    for (const std::string command : {"run", "info"}) {
      const Ended ended = call({command, log.string()});
      if (command == "info" && ended.exit_code == 0) continue;  // only a solve finds it
      expect_failure(ended, 3, part);
      EXPECT_THAT(ended.err, HasSubstr(log.string() + place)) << command;
    }
    expect_failure(call({"solve", log.string(), "-o", (folder.path() / "map.g2o").string()}), 3, part);
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "map.g2o"));
  }
  TemporaryFolder folder;
};

TEST_F(BadInput, AMissingFileIsNamed) {
  expect_failure(call({"run", (folder.path() / "nowhere.g2o").string()}), 3, "nowhere.g2o: No such file or directory");
  expect_failure(call({"info", (folder.path() / "nowhere.g2o").string()}), 3, "nowhere.g2o");
  expect_failure(call({"join", (folder.path() / "nowhere").string(), "-o", (folder.path() / "map.g2o").string()}), 3,
                 "nowhere");
}

TEST_F(BadInput, AMalformedNumberIsNamedWithItsPlace) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 O 0 1 0 0 1 0 1\n", ":5:16: ", "O");
}

TEST_F(BadInput, ATruncatedLineIsNamedWithItsPlace) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 0\n", ":5:", "");
}

TEST_F(BadInput, NotANumberIsRefused) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 nan 0 0 1 0 0 1 0 1\n", ":5:14: ", "nan");
}

TEST_F(BadInput, AnIndefiniteInformationMatrixIsNamedByItsEdge) {
  expect_refused(kSmallLog + "EDGE_SE2 2 3 1 0 0 1 0 0 -1 0 1\n", ":5:", "the edge from pose 2 to pose 3");
}

TEST_F(BadInput, AnUnknownIdIsNamed) {
  expect_refused("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 5 1 0 0 1 0 0 1 0 1\n",
                 ":4:", "5");
}

TEST_F(BadInput, ALogThatFallsApartIsNamedByItsParts) {
  expect_refused(kSmallLog + "EDGE_SE2 10 11 1 0 0 1 0 0 1 0 1\n", "", "10");
}

TEST_F(BadInput, NumbersTooLargeForAMapAreRefused) {
  const auto log = folder.file("log.g2o", "EDGE_SE2 0 1 1e308 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1e308 0 0 1 0 0 1 0 1\n");
  const auto out = folder.path() / "out";
  for (const std::string command : {"run", "solve"}) {
    expect_failure(call({command, log.string(), "-o", out.string()}), 3, "the map is not finite");
    EXPECT_FALSE(std::filesystem::exists(out)) << command;
  }
}

TEST_F(BadInput, ATruncatedMatFileIsRefused) {
  const auto log = folder.file("log.mat", "MATLAB 5.0 MAT-file, but no more");
  expect_failure(call({"run", log.string()}), 3, "log.mat");
}

TEST_F(BadInput, LocalMapsInThePlaceOfALogAreToldApart) {
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"run", store}), 3, "`mapjoin join` takes");
  expect_failure(call({"run", folder.path().string()}), 3, "`mapjoin join` takes");
  expect_failure(call({"join", log.string(), "-o", (folder.path() / "map.g2o").string()}), 3, "neither");
}

TEST_F(BadInput, AStoreThatIsCutShortIsRefused) {
  const auto log = folder.file("log.g2o", kSmallLog);
  const auto store = folder.path() / "maps";
  ASSERT_EQ(call({"build", log.string(), "-o", store.string()}).exit_code, 0);
  std::filesystem::resize_file(store, std::filesystem::file_size(store) / 2);
  expect_failure(call({"join", store.string(), "-o", (folder.path() / "map.g2o").string()}), 3, "maps");
}

TEST_F(BadInput, WhatIsWrongInAStoreIsSaidOfTheStore) {
  Log<2> log = std::get<Log<2>>(*open_log(folder.file("log.g2o", kSmallLog)));
  log.graph.feature_factors.clear();
  const auto store = folder.path() / "maps";
  auto writer = StoreWriter<2>::open(store, log, {{0, 2, false}}, "");
  ASSERT_TRUE(writer && writer->finish());
  const Ended ended = call({"join", store.string(), "-o", (folder.path() / "map.g2o").string()});
  expect_failure(ended, 3, "feature 7 is never observed");
  EXPECT_THAT(ended.err, StartsWith("mapjoin: " + store.string() + ": "));
}

TEST(Repair, TakesTheNearestSemidefiniteMatrixAndCountsIt) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog + "EDGE_SE2 1 2 1 0 0 2 0 0 2 0 -1\n");
  ASSERT_EQ(call({"run", log.string()}).exit_code, 3);
  EXPECT_EQ(report_of({"run", log.string(), "--repair-information"}).at("repaired_informations"), 1);
}

TEST(Repair, SaysHowAsymmetricWhatItTookWas) {
  const TemporaryFolder folder;
  const auto map = [&](const std::string& above) {
    folder.file("localmap_1.txt", "0\n3\n-1 1\n-1 0.5\n-1 0.1\n4 " + above + " 0\n1 3 0\n0 0 2\n");
  };
  map("1.0000004");
  const Ended taken = call({"join", folder.path().string()});
  EXPECT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_THAT(taken.out, HasSubstr("1 information matrix or covariance was replaced by the symmetric part: entries across the "
                                   "diagonal differ by up to 1e-07 of the largest"));
  map("1.1");
  const Ended refused = call({"join", folder.path().string()});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, HasSubstr("the information matrix of map 1 is not symmetric"));
  EXPECT_THAT(refused.err, HasSubstr("--repair-information takes its symmetric part"));
  EXPECT_EQ(report_of({"join", folder.path().string(), "--repair-information"}).at("symmetrised_matrices"), 1);
}

TEST_F(BadInput, ASecondFixedPoseNeedsAValue) {
  const auto log = folder.file("log.g2o", "FIX 0\nFIX 2\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  expect_failure(call({"run", log.string()}), 3, "pose 2 is fixed beside pose 0, but nothing says where");
}

TEST(Usage, NamesInBracketsAreNames) {
  const TemporaryFolder folder;
  ProcessOptions there;
  there.working_folder = folder.path();
  folder.file("[a,b]", kSmallLog);
  EXPECT_EQ(call({"plot", "[a,b]", "-o", "a.svg"}, there).exit_code, 0);
  EXPECT_EQ(call({"info", kBundledLog, "[a,b]"}, there).exit_code, 0);
}

TEST(Usage, EveryViolationIsNamed) {
  const Ended ended =
      call({"run", "log", "--jobs", "none", "--schedule", "forest", "--poses-per-map", "0", "--metres-per-map", "x"});
  expect_failure(ended, 2, "--jobs is \"none\"");
  EXPECT_THAT(ended.err, AllOf(HasSubstr("--schedule is \"forest\""), HasSubstr("--poses-per-map is \"0\""),
                               HasSubstr("--metres-per-map is \"x\""), HasSubstr("only one of")));
}

TEST(Usage, WhatIsMissingOrUnknownIsNamed) {
  expect_failure(call({}), 2, "command");
  expect_failure(call({"run"}), 2, "LOG");
  expect_failure(call({"build", "log"}), 2, "--output");
  expect_failure(call({"fly", "log"}), 2, "there is no command \"fly\" (see mapjoin --help)");
  expect_failure(call({"fly", "run"}), 2, "there is no command \"fly\" (see mapjoin --help)");
  expect_failure(call({"run", "log", "--faster"}), 2, "--faster");
  expect_failure(call({"simulate", "-o", "log", "--chance", "2", "--block", "1.5"}), 2, "chance");
}

TEST(Usage, TheHelpOfTheCommandIsNamed) {
  expect_failure(call({"run"}), 2, "LOG is required (see mapjoin run --help)");
  expect_failure(call({"solve", "log", "--faster"}), 2, "--faster (see mapjoin solve --help)");
}

TEST(Usage, AFolderIsSpokenOfWhereOneIsWritten) {
  const std::string folder = " (a new folder has none, or ends in /)\n";
  EXPECT_THAT(call({"run", "log", "-o", "town.txt"}).err, EndsWith(".csv and .mat" + folder));
  EXPECT_THAT(call({"solve", "log", "-o", "town.txt"}).err, EndsWith(".csv and .mat\n"));
}

TEST(Usage, ThreadsHaveALimit) {
  expect_failure(call({"run", "log", "--jobs", "1025"}), 2, "not a whole number from 1 to 1024");
}

TEST(Usage, ALocalMapMayHaveMorePosesThanThereAre) {
  const TemporaryFolder folder;
  const std::string log = folder.file("log.g2o", kSmallLog).string();
  EXPECT_EQ(call({"run", log, "--poses-per-map", "100000000000"}).exit_code, 0);
}

TEST(Usage, NoPathIsEmpty) {
  expect_failure(call({"run", "log", "-o", ""}), 2, "--output");
  expect_failure(call({"build", "log", "-o", ""}), 2, "--output");
  expect_failure(call({"run", ""}), 2, "LOG");
}

TEST(Usage, ADashIsStandardOutputOrRefused) {
  const std::string refused = "is -, which stands for no stream here: name /dev/stdin or /dev/stdout";
  expect_failure(call({"run", "-"}), 2, "LOG: " + refused);
  expect_failure(call({"check", "log", "-"}), 2, "FURTHER: " + refused);
  expect_failure(call({"solve", "log", "-o", "-"}), 2, "--output: " + refused);
  expect_failure(call({"convert", "log", "-", "--to", "isam"}), 2, "OUT: " + refused);
  expect_failure(call({"run", "log", "-o", "-"}), 2, "--output: " + refused);
  expect_failure(call({"compare", "log", "-o", "-"}), 2, "--output: is -, which stands for no stream here: name a folder");
}

TEST(Errors, AWordOfRobustThatStandsApartIsOfferedBehindTheEqualsSign) {
  for (const auto& words :
       {std::vector<std::string>{"run", "log.g2o", "--robust", "all"}, {"run", "--robust", "all", "log.g2o"}}) {
    expect_failure(call(words), 2, "--robust takes its word behind =: --robust=all");
  }
}

TEST(Errors, ARemedyThatACommandLacksIsOfferedWithTheCommandThatHasIt) {
  const TemporaryFolder folder;
  const auto apart = folder.file("log.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n").string();
  const std::string remedy = "; --parts largest takes the largest, --parts all makes a map of each";
  EXPECT_THAT(call({"run", apart}).err, EndsWith(remedy + "\n"));
  EXPECT_THAT(
      call({"basin", apart}).err,
      EndsWith(remedy + "; --parts goes with `mapjoin run -o DIR`, and DIR, or with all DIR/part_1, …, can be given here\n"));
  const std::string all = remedy + "; --parts all goes with `mapjoin run -o DIR`, and DIR/part_1, … can be given here\n";
  for (const char* name : {"compare", "solve"}) EXPECT_THAT(call({name, apart}).err, EndsWith(all)) << name;
  const std::string run = (folder.path() / "run").string();
  ASSERT_EQ(call({"run", apart, "--parts", "largest", "-o", run, "--quiet"}).exit_code, 0);
  EXPECT_EQ(call({"basin", run, "--seeds", "1"}).exit_code, 0);
  const auto unknown = folder.file("unknown.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nSOMETHING 1\n").string();
  const std::string map = (folder.path() / "map.svg").string();
  EXPECT_THAT(call({"solve", unknown}).err, EndsWith("; --skip-unknown leaves such lines out\n"));
  EXPECT_THAT(call({"plot", unknown, "-o", map}).err, EndsWith("; --skip-unknown leaves such lines out\n"));
  const auto robot = folder.file("robot.g2o", "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\n").string();
  const std::string undeclared = "not pose 7; give the file that does as FURTHER, or --skip-undeclared";
  EXPECT_THAT(call({"run", robot}).err, EndsWith(undeclared + "\n"));
  EXPECT_THAT(call({"convert", robot, map + ".graph"}).err,
              EndsWith(undeclared + "; FURTHER goes with `mapjoin run -o DIR`, and DIR can be given here\n"));
  EXPECT_THAT(call({"plot", robot, apart, "-o", map}).err,
              EndsWith(undeclared + "; FURTHER goes with `mapjoin run -o DIR`, and DIR can be given here\n"));
}

TEST(Usage, AnOptionOfWhatIsNotAskedForIsNamed) {
  expect_failure(call({"solve", "log.g2o", "--seed", "3"}), 2, "--seed is of --start random");
  expect_failure(call({"convexity", "log.g2o", "--spread", "2"}), 2, "--spread is of --states drift");
  expect_failure(call({"simulate", "-o", "log.g2o", "--storeys", "2"}), 2, "--storeys is of --dim 3");
}

TEST(Usage, WhatWouldCountTwiceIsGivenOnce) {
  const TemporaryFolder folder;
  const std::string log = folder.file("log.g2o", kSmallLog).string();
  const std::string again = folder.path().string() + "/./log.g2o";
  for (const std::string command : {"run", "check", "solve", "compare"}) {
    expect_failure(call({command, log, again}), 2, again + " is given twice");
  }
  const std::string store = (folder.path() / "maps").string();
  ASSERT_EQ(call({"build", log, "-o", store}).exit_code, 0);
  for (const std::string command : {"join", "check"}) {
    expect_failure(call({command, store, store}), 2, store + " is given twice: leave one out");
  }
  std::filesystem::copy_file(store, store + "2");
  EXPECT_EQ(report_of({"join", store, store + "2"})["poses"], report_of({"join", store})["poses"]) << "of one log";
  const std::string maps = (folder.path() / "of_others").string();
  ASSERT_EQ(call({"convert", store, maps, "--to", "maps-text"}).exit_code, 0);
  expect_failure(call({"join", maps, maps}), 2, maps + " is given twice: leave one out");
  const std::string stored = (folder.path() / "stored").string();
  ASSERT_EQ(call({"build", maps, "-o", stored}).exit_code, 0);
  expect_failure(call({"join", stored, stored}), 2, stored + " is given twice: leave one out");
}

TEST(Usage, APictureHasTheExtensionOfOne) {
  const TemporaryFolder folder;
  const std::string log = folder.file("log.g2o", kSmallLog).string();
  const std::string image = (folder.path() / "map.png").string();
  expect_failure(call({"plot", log, "-o", image}), 2, image + " has neither the extension of a picture, .svg, nor");
  EXPECT_FALSE(std::filesystem::exists(image));
  EXPECT_EQ(call({"plot", log, "-o", (folder.path() / "picture").string()}).exit_code, 0);
}

TEST(Usage, AStartIsForTheBatchSchedule) {
  expect_failure(call({"solve", "log.g2o", "-o", "map", "--start", "zero", "--schedule", "tree"}), 2, "--start");
}

TEST(Usage, TheWeightsOfAStoreAreThoseItWasBuiltWith) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  const std::string map = (folder.path() / "map.g2o").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"join", store, "-o", map, "--covariance", "identity"}), 2, "build");
  expect_failure(call({"join", store, "-o", map, "--repair-information"}), 2, "build");
  expect_failure(call({"info", store, "--covariance", "identity"}), 2, "build");
}

TEST(Usage, LocalMapsAreNotBuiltAgain) {
  const TemporaryFolder folder;
  const auto log = folder.file("log.g2o", kSmallLog);
  const std::string store = (folder.path() / "maps").string();
  const std::string again = (folder.path() / "again").string();
  ASSERT_EQ(call({"build", log.string(), "-o", store}).exit_code, 0);
  expect_failure(call({"build", store, "-o", again}), 2, "maps: is a store already");
  expect_failure(call({"build", store, "-o", again, "--poses-per-map", "5"}), 2, "--poses-per-map");
  EXPECT_FALSE(std::filesystem::exists(again));
}

}  // namespace
}  // namespace mapjoin::testing
