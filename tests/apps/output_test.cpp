// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <mapjoin/io/store/store.hpp>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Output : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  TemporaryFolder folder;
};

TEST_F(Output, ARunFillsItsFolder) {
  const Ended ended = call({"run", kBundledLog, "-o", path("some/where")});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(names_in(path("some/where")),
            (std::vector<std::string>{"features.csv", "map.g2o", "map.svg", "poses.csv", "report.json", "trajectory.tum"}));
}

TEST_F(Output, ARunTakesAwayWhatAnEarlierOneWroteMore) {
  fs::create_directories(path("out/associations.csv"));
  for (const std::string name : {"relations.csv", "notes.csv"}) folder.file("out/" + name, "mine");
  EXPECT_EQ(call({"run", kBundledLog, "-o", path("out"), "--covariances", "--robust"}).exit_code, 0);
  EXPECT_EQ(names_in(path("out")).size(), 12U);
  EXPECT_EQ(call({"run", kBundledLog, "-o", path("out")}).exit_code, 0);
  EXPECT_EQ(names_in(path("out")),
            (std::vector<std::string>{"associations.csv", "features.csv", "map.g2o", "map.svg", "notes.csv", "poses.csv",
                                      "relations.csv", "report.json", "trajectory.tum"}));
  EXPECT_EQ(content_of(path("out/relations.csv")), "mine") << "no run wrote it";
}

TEST_F(Output, FilesOfARunKeepThePermissionsOfThoseThatTheyReplace) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("out")}).exit_code, 0);
  for (const std::string& name : names_in(path("out"))) fs::permissions(path("out/" + name), fs::perms(0604));
  fs::remove(path("out/map.svg"));
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("out")}).exit_code, 0);
  for (const std::string& name : names_in(path("out"))) {
    EXPECT_EQ(fs::status(path("out/" + name)).permissions() == fs::perms(0604), name != "map.svg") << name;
  }
}

TEST_F(Output, TakesNothingAwayOnTheWordOfAReportThatIsNone) {
  fs::create_directories(path("out"));
  for (const std::string report :
       {"", "no JSON", "[]", R"({"files":5})", R"({"files":[5,"out/report.json","../notes"]})",
        R"({"files":["out/rejected.csv"]})", R"({"files":["other/rejected.csv","out/report.json"]})"}) {
    folder.file("notes", "mine");
    folder.file("out/rejected.csv", "mine");
    folder.file("out/report.json", report);
    const Ended ended = call({"run", kBundledLog, "-o", path("out")});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_TRUE(fs::exists(path("notes")) && fs::exists(path("out/rejected.csv"))) << report;
  }
}

TEST_F(Output, IsTheSameBytesForAnyNumberOfThreads) {
  for (const std::string jobs : {"1", "2"})
    ASSERT_EQ(call({"run", kBundledLog, "-o", path(jobs), "--jobs", jobs}).exit_code, 0);
  for (const std::string name : {"map.g2o", "trajectory.tum", "poses.csv", "features.csv"}) {
    EXPECT_EQ(content_of(path("1/" + name)), content_of(path("2/" + name))) << name;
  }
}

TEST_F(Output, TheFormatGoesByTheName) {
  for (const std::string command : {"solve", "run"}) {
    ASSERT_TRUE(fs::create_directory(path(command)));
    for (const std::string name : {"map.g2o", "map.tum", "map.csv", "CAPITALS.G2O"}) {
      const Ended ended = call({command, kBundledLog, "-o", path(command + "/" + name)});
      EXPECT_EQ(ended.exit_code, 0) << ended.err;
    }
    EXPECT_EQ(names_in(path(command)),
              (std::vector<std::string>{"CAPITALS.G2O", "map.csv", "map.features.csv", "map.g2o", "map.tum"}));
    EXPECT_EQ(content_of(path(command + "/CAPITALS.G2O")), content_of(path(command + "/map.g2o")));
    EXPECT_THAT(content_of(path(command + "/map.g2o")), HasSubstr("VERTEX_SE2 "));
    EXPECT_THAT(content_of(path(command + "/map.tum")), StartsWith("# index x y z qx qy qz qw"));
    EXPECT_THAT(content_of(path(command + "/map.csv")), StartsWith("pose,x,y,phi\n"));
    EXPECT_THAT(content_of(path(command + "/map.features.csv")), StartsWith("feature,x,y\n"));
  }
}

TEST_F(Output, AnExtensionThatNoMapHasIsRefused) {
  for (const std::string command : {"run", "solve", "join"}) {
    for (const std::string name : {"x.txt", "y.xyz", "results.v2"}) {
      const Ended ended = call({command, kBundledLog, "-o", path(name)});
      EXPECT_EQ(ended.exit_code, 2) << command << name;
      EXPECT_THAT(ended.err, HasSubstr(name + " has none of the extensions of a map, .g2o, .tum, .csv and .mat"));
      EXPECT_FALSE(fs::exists(path(name)));
    }
  }
  expect_failure(call({"solve", kBundledLog, "-o", path("new/")}), 2,
                 "new/ is a folder, as `mapjoin run` writes a map; name a file");
  for (const std::string name : {"log.g2o.gz", "log.csv"}) {
    expect_failure(call({"simulate", "--poses", "9", "-o", path(name)}), 2, "the log is written in g2o, and " + path(name));
  }
  ASSERT_TRUE(fs::create_directory(path("results.v2")));
  for (const std::string name : {"results.v2", "results.v3/"}) {
    EXPECT_EQ(call({"run", kBundledLog, "-o", path(name)}).exit_code, 0) << name;
    EXPECT_TRUE(fs::exists(path(name) + "/map.g2o")) << name;
  }
}

TEST_F(Output, IsWhollyTheUsersChoice) {
  for (const std::string command : {"run", "solve"}) {
    const Ended ended = call({command, kBundledLog, "--report", "-"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_NEAR(nlohmann::json::parse(ended.out)["chi2"], 4702.179445, 1e-4);
  }
}

TEST_F(Output, OfOneMapHasItsCertaintyBeside) {
  for (const std::string command : {"run", "solve"}) {
    const Ended ended = call({command, kBundledLog, "-o", path(command + ".g2o"), "--covariances", "--relations"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    for (const std::string ending : {".g2o", ".covariances.json", ".relations.csv"}) {
      EXPECT_TRUE(fs::exists(path(command + ending))) << command << ending;
    }
    EXPECT_EQ(call({command, kBundledLog, "-o", path("a.csv"), "--report", path("a.features.csv")}).exit_code, 2);
    EXPECT_EQ(
        call({command, kBundledLog, "-o", path("b.g2o"), "--covariances", "--report", path("b.covariances.json")}).exit_code,
        2);
  }
  EXPECT_FALSE(fs::exists(path("a.csv")) || fs::exists(path("b.g2o")));
}

TEST_F(Output, AFolderMayHaveTheNameOfAMap) {
  ASSERT_TRUE(fs::create_directory(path("tested.g2o")));
  const Ended ended = call({"run", kBundledLog, "-o", path("tested.g2o")});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(fs::exists(path("tested.g2o/map.g2o")));
}

TEST_F(Output, ARunDoesNotWriteOverItsLog) {
  ASSERT_TRUE(fs::copy_file(kBundledLog, path("log.g2o")));
  EXPECT_EQ(call({"run", path("log.g2o"), "-o", path("log.g2o")}).exit_code, 2);
  EXPECT_EQ(content_of(path("log.g2o")), content_of(kBundledLog));
}

TEST_F(Output, ABuildThatIsJoinedGivesTheMapOfARun) {
  ASSERT_EQ(call({"run", kBundledLog, "-o", path("run")}).exit_code, 0);
  ASSERT_EQ(call({"build", kBundledLog, "-o", path("maps")}).exit_code, 0);
  ASSERT_EQ(call({"join", path("maps"), "-o", path("map.csv")}).exit_code, 0);
  EXPECT_EQ(content_of(path("map.csv")), content_of(path("run/poses.csv")));
  EXPECT_EQ(content_of(path("map.features.csv")), content_of(path("run/features.csv")));
}

TEST_F(Output, ASolveFromTheValuesOfASolvedMapStaysThere) {
  ASSERT_EQ(call({"solve", kBundledLog, "-o", path("map.g2o")}).exit_code, 0);
  const auto again = report_of({"solve", path("map.g2o"), "--start", "file", "-o", path("again.g2o")});
  EXPECT_EQ(again.at("join").at("start"), "file");
  EXPECT_EQ(again.at("join").at("schedule"), "batch");
  EXPECT_LE(again.at("join").at("iterations"), 2);
}

TEST_F(Output, WhatDoesNotConvergeIsWrittenAndMarked) {
  const Ended ended = call({"solve", kBundledLog, "-o", path("map.g2o"), "--max-iterations", "1", "--report", "-"});
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_THAT(ended.err, StartsWith("mapjoin: the join did not converge"));
  EXPECT_EQ(nlohmann::json::parse(ended.out).at("converged"), false);
  EXPECT_TRUE(fs::exists(path("map.g2o")));
  EXPECT_THAT(call({"solve", kBundledLog, "-o", path("map.g2o"), "--max-iterations", "1"}).out, HasSubstr("DID NOT CONVERGE"));
}

TEST_F(Output, ABuildThatGoesOnDoesNotKnowOfTheIterationsBefore) {
  const std::vector<std::string> build = {"build", kBundledLog, "-o", path("maps"), "--poses-per-map", "2"};
  EXPECT_GT(report_of(build).at("local_maps").at("iterations"), 0);
  const auto stored = std::get<StoredMaps<2>>(*read_store(path("maps")));
  {
    auto writer = StoreWriter<2>::open(path("maps"), stored.log, stored.segments, stored.options);
    ASSERT_TRUE(writer);
    for (std::size_t k = 0; k < 300; ++k) ASSERT_TRUE(writer->add(k, stored.maps.at(k)));
  }
  EXPECT_TRUE(report_of(build).at("local_maps").at("iterations").is_null());
}

TEST_F(Output, ABuildSaysThatWhatWasLeftOfAnotherIsDamaged) {
  folder.file("maps.partial", std::string(50'000, 'x'));
  const Ended ended = call({"build", kBundledLog, "-o", path("maps"), "--poses-per-map", "50"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("what an interrupted build had left was damaged: the build began afresh"));
  EXPECT_TRUE(read_store(path("maps")));
}

TEST_F(Output, ABuildKeepsTheLocalMapsOfOthersAsTheyAre) {
  const fs::path maps = fs::path(path("maps"));
  fs::create_directory(maps);
  for (const int k : {1, 2}) {
    std::ofstream map(maps / ("localmap_" + std::to_string(k) + ".txt"));
    map << k - 1 << "\n5\n-" << k << " 1\n-" << k << " 0.5\n-" << k << " 0.1\n7 2\n7 " << k << "\n";
    for (const char* row : {"9 1 0 0 0", "1 8 0 0 0", "0 0 7 0 0", "0 0 0 6 2", "0 0 0 2 5"}) map << row << "\n";
  }
  ASSERT_EQ(call({"build", maps.string(), "-o", path("store")}).exit_code, 0);
  for (const std::string from : {"maps", "store"}) {
    ASSERT_EQ(call({"join", path(from), "-o", path(from + ".g2o")}).exit_code, 0);
  }
  EXPECT_EQ(content_of(path("store.g2o")), content_of(path("maps.g2o")));
  EXPECT_THAT(content_of(path("store.g2o")), HasSubstr("VERTEX_XY 7 "));
}

TEST_F(Output, AFolderThatCannotBeIsAnErrorThatLeavesNothing) {
  folder.file("file", "in the way");
  for (const std::string& where : {path("file"), path("file/below"), std::string("/proc/nowhere")}) {
    const Ended ended = call({"run", kBundledLog, "-o", where});
    EXPECT_EQ(ended.exit_code, 5);
    EXPECT_THAT(ended.err, StartsWith("mapjoin: " + where + ": "));
  }
  EXPECT_EQ(content_of(path("file")), "in the way");
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"file"});
}

TEST_F(Output, AFileThatCannotBeIsAnErrorBeforeTheWork) {
  for (const std::string command : {"solve", "build", "simulate"}) {
    std::vector<std::string> arguments = {command, "-o", path("nowhere/file")};
    if (command != "simulate") arguments.push_back(kBundledLog);
    EXPECT_EQ(call(arguments).exit_code, 5) << command;
  }
  EXPECT_EQ(call({"run", kBundledLog, "--report", path("nowhere/report.json")}).exit_code, 5);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST_F(Output, AFolderInTheWayOfAFileIsAnErrorThatLeavesNothing) {
  fs::create_directories(path("out/map.svg"));
  EXPECT_EQ(call({"run", kBundledLog, "-o", path("out")}).exit_code, 5);
  EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"map.svg"});

  fs::create_directory(path("map.features.csv"));
  for (const auto& [command, name] : {std::pair("solve", "map.csv"), std::pair("solve", "out"), std::pair("build", "out")}) {
    const Ended ended = call({command, kBundledLog, "-o", path(name)});
    EXPECT_EQ(ended.exit_code, 5) << command << " " << name;
    EXPECT_THAT(ended.err, HasSubstr("Is a directory"));
  }
  EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"map.features.csv", "out"}));
}

TEST_F(Output, NamesWithoutRoomAreRefusedBeforeTheWork) {
  const std::string edge = "EDGE_SE2 {} {} 1 0 0 1 0 0 1 0 1\n";
  const std::string untied = fmt::format(fmt::runtime(edge + edge), 6989586621679009792U, 6989586621679009793U, 0, 1);
  for (const std::string command : {"run", "solve"}) {
    expect_failure(call({command, folder.file("untied.g2o", untied), "-o", path("map.mat")}), 2,
                   "pose a0 has an id of 2^53 or more, which a MAT file cannot say; .csv can");
  }
  const std::string large = fmt::format(fmt::runtime(edge), 10'000'000'000'000'000'000U, 10'000'000'000'000'000'001U);
  const std::string first = folder.file("first.g2o", large + fmt::format(fmt::runtime(edge), 0, 1));
  const std::string second = folder.file("second.g2o", large);
  expect_failure(call({"run", first, second, "-o", path("out")}), 2, "do not fit; a map in .csv has room for them");
}

TEST_F(Output, WhatIsInTheWayOfAnUnfinishedFileIsNamed) {
  ASSERT_TRUE(fs::create_directories(path("map.g2o.mapjoin-tmp")));
  const Ended file = call({"solve", kBundledLog, "-o", path("map.g2o")});
  EXPECT_EQ(file.exit_code, 5);
  EXPECT_EQ(file.err, "mapjoin: " + path("map.g2o.mapjoin-tmp") + " is in the way of " + path("map.g2o") + ": remove it\n");
  ASSERT_TRUE(fs::create_directory(path("result")));
  folder.file("result/.mapjoin-tmp", "a file");
  const Ended in_folder = call({"run", kBundledLog, "-o", path("result")});
  EXPECT_EQ(in_folder.exit_code, 5);
  EXPECT_EQ(in_folder.err, "mapjoin: " + path("result/.mapjoin-tmp") + " is in the way of " + path("result") + ": remove it\n");
}

TEST_F(Output, AReportGoesIntoTheFolderOfARun) {
  const Ended ended = call({"run", kBundledLog, "-o", path("out"), "--report", path("out/mine.json")});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(fs::exists(path("out/mine.json")));
}

TEST_F(Output, AFullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "Needs /dev/full.";
  ProcessOptions full;
  full.standard_output = "/dev/full";
  EXPECT_EQ(call({"run", kBundledLog}, full).exit_code, 5);
  EXPECT_EQ(call({"run", kBundledLog, "--report", "-"}, full).exit_code, 5);
  EXPECT_EQ(call({"info", kBundledLog}, full).exit_code, 5);
  EXPECT_EQ(call({"--help"}, full).exit_code, 5);
  EXPECT_EQ(call({"run", kBundledLog, "--report", "/dev/full"}).exit_code, 5);
  EXPECT_EQ(call({"solve", kBundledLog, "-o", "/dev/full"}).exit_code, 5);
}

}  // namespace
}  // namespace mapjoin::testing
