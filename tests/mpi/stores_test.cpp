// SPDX-License-Identifier: BSD-3-Clause
// Stores of ranks: runs that go on from them, and joins of them.
#include <gmock/gmock.h>

#include <fstream>
#include <mapjoin/io/store/store.hpp>
#include <tests/mpi/ranks_test.hpp>
#include <tests/support/sqlite.hpp>

namespace mapjoin::testing {
namespace {

using ::testing::HasSubstr;

class StoresOfRanks : public RanksTest {
 protected:
  Ended build(int ranks, const std::string& log, const std::string& poses_per_map = "20") const {
    return call_ranks(ranks, {"build", log, "-o", path("stores"), "--poses-per-map", poses_per_map});
  }
  std::string store(int rank, int ranks) const {
    return path("stores/" + std::to_string(rank) + "-of-" + std::to_string(ranks) + ".maps");
  }
  std::vector<std::string> all_stores(int ranks, std::vector<std::string> before) const {
    for (int rank = ranks; rank > 0; --rank) before.push_back(store(rank, ranks));
    return before;
  }
  std::vector<std::string> checkpointed(const std::string& map) const {
    return {"run", log, "-o", map, "--poses-per-map", "20", "--checkpoint", path("stores")};
  }

  /// Expects the report of ranks to be that of one process, but for the last digits of chi2.
  static void expect_the_same(const nlohmann::json& ranks, const nlohmann::json& one) {
    for (const char* what : {"dimension", "convention", "poses", "features", "odometry", "closures", "observations", "priors",
                             "fixed_poses", "dof", "gauge"}) {
      EXPECT_EQ(ranks[what], one[what]) << one["input"] << ": " << what;
    }
    EXPECT_EQ(ranks["local_maps"]["count"], one["local_maps"]["count"]) << one["input"];
    EXPECT_NEAR(ranks["chi2"], one["chi2"], 1e-8 * one["chi2"].get<double>() + 1e-12) << one["input"];
  }

  void expect_joined_as_by_one(const std::string& any) const {
    ASSERT_EQ(call({"build", any, "-o", path("any.maps")}).exit_code, 0);
    const auto one = report_of({"join", path("any.maps"), "--no-verdict"});
    for (const int ranks : {2, 4}) expect_the_same(report_of_ranks(ranks, {"join", path("any.maps")}), one);
  }

  std::string log = bundled("manhattan2d.g2o");
};

TEST_F(StoresOfRanks, AreTakenByOneProcessAsTheLog) {
  for (const char* name : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    const auto one = report_of({"run", bundled(name), "--poses-per-map", "20", "--no-verdict"});
    for (const int ranks : {1, 2, 4}) {
      ASSERT_EQ(build(ranks, bundled(name)).exit_code, 0);
      const auto joined = report_of(all_stores(ranks, {"join", "--no-verdict"}));
      for (const char* what : {"dimension", "convention", "poses", "features", "odometry", "closures", "observations", "priors",
                               "fixed_poses", "dof", "gauge"}) {
        EXPECT_EQ(joined[what], one[what]) << name << " on " << ranks << ": " << what;
      }
      EXPECT_GT(joined["local_maps"]["count"], 10);
      EXPECT_NEAR(joined["chi2"], one["chi2"], 1e-9 * one["chi2"].get<double>()) << name << " on " << ranks;
      std::filesystem::remove_all(path("stores"));
    }
  }
}

TEST_F(StoresOfRanks, HoldOneAfterTheOtherEveryFactorOnce) {
  ASSERT_EQ(build(4, log).exit_code, 0);
  std::size_t observations = 0;
  for (int rank = 1; rank <= 4; ++rank) {
    const auto stored = std::get<StoredMaps<2>>(read_store(store(rank, 4)).value());
    EXPECT_EQ(stored.portion, (Portion{static_cast<std::size_t>(rank - 1), 4}));
    observations += stored.log.observations().size();
    EXPECT_LT(stored.log.observations().size(), 2 * observations / static_cast<std::size_t>(rank));
  }
  EXPECT_EQ(observations, report_of({"solve", log, "--no-verdict"})["observations"]);
}

TEST_F(StoresOfRanks, AreJoinedAllOrNone) {
  ASSERT_EQ(build(2, log).exit_code, 0);
  const Ended one = call({"join", store(2, 2)});
  EXPECT_EQ(one.exit_code, 3);
  EXPECT_THAT(one.err, HasSubstr("the store has portion 2 of 2 of its log: give those of all 2 to `mapjoin join`"));
  std::filesystem::copy_file(store(2, 2), path("copy.maps"));
  const Ended twice = call({"join", store(2, 2), path("copy.maps")});
  EXPECT_EQ(twice.exit_code, 3);
  EXPECT_THAT(twice.err, HasSubstr("its 2 portions are to be joined together, each once; there are 2 stores"));
}

TEST_F(StoresOfRanks, OfLogsThatDifferAreNotPortionsOfOne) {
  ASSERT_EQ(build(2, log).exit_code, 0);
  std::filesystem::rename(store(1, 2), path("first.maps"));
  std::ofstream(path("other.g2o")) << content_of(log) << "EDGE_PRIOR_XY 1000 5 5 4 0 4\n";
  ASSERT_EQ(build(2, path("other.g2o")).exit_code, 0);
  const Ended mixed = call({"join", path("first.maps"), store(2, 2)});
  EXPECT_EQ(mixed.exit_code, 3);
  EXPECT_THAT(mixed.err, HasSubstr("its 2 portions are to be joined together, each once; there are 1 store"));
}

TEST_F(StoresOfRanks, AreJoinedByAnyNumberOfRanks) {
  for (const char* name : {"manhattan2d.g2o", "manhattan3d.g2o"}) {
    ASSERT_EQ(build(4, bundled(name)).exit_code, 0);
    const auto one = report_of(all_stores(4, {"join", "--no-verdict"}));
    for (const int ranks : {1, 2, 4}) expect_the_same(report_of_ranks(ranks, all_stores(4, {"join"})), one);
    std::filesystem::remove_all(path("stores"));
  }
}

TEST_F(StoresOfRanks, OfOneProcessAreJoinedByRanks) {
  for (const char* part : {"1/3", "2/3", "3/3"}) {
    ASSERT_EQ(call({"build", log, "-o", path(std::string("part") + part[0]), "--part", part}).exit_code, 0);
  }
  const auto one = report_of({"join", path("part1"), path("part3"), "--no-verdict"});
  for (const int ranks : {1, 2, 4}) expect_the_same(report_of_ranks(ranks, {"join", path("part1"), path("part3")}), one);
  const auto all = report_of_ranks(2, {"join", path("part1"), path("part3"), path("part2"), "-o", path("map.g2o")});
  EXPECT_GT(all["local_maps"]["count"], one["local_maps"]["count"]);
  EXPECT_TRUE(std::filesystem::exists(path("map.g2o")));
}

TEST_F(StoresOfRanks, OfPosesInAnyOrderAreJoinedByRanks) {
  std::ofstream file(path("shuffled.g2o"));
  for (int k = 0; k < 96; ++k) file << "EDGE_SE2 " << k * 7 % 97 << ' ' << (k + 1) * 7 % 97 << " 1 0 .1 1 0 0 1 0 1\n";
  for (int k = 0; k < 30; ++k) file << "EDGE_SE2 " << k * 7 % 97 << ' ' << (k + 63) * 7 % 97 << " 0 0 0 1 0 0 1 0 1\n";
  file.close();
  expect_joined_as_by_one(path("shuffled.g2o"));
}

TEST_F(StoresOfRanks, OfRealLogsInAnyFormatAreJoinedByRanks) {
  for (const char* file :
       {"vicpark-6898/vicpark6898.g2o.gz", "pose-graphs-2d/intel.g2o.gz", "pose-graphs-3d/parking-garage.g2o.gz"}) {
    expect_joined_as_by_one(data_file(file).string());
  }
}

TEST_F(StoresOfRanks, MayEndWithASegmentThatIsLongerThanAShare) {
  std::ofstream file(path("still.g2o"));  // a drive, then a stop
  for (int k = 0; k < 400; ++k) file << "EDGE_SE2 " << k << ' ' << k + 1 << (k < 80 ? " 1" : " 0") << " 0 0 1 0 0 1 0 1\n";
  file.close();
  ASSERT_EQ(call({"build", path("still.g2o"), "-o", path("still.maps"), "--metres-per-map", "20"}).exit_code, 0);
  const auto one = report_of({"join", path("still.maps"), "--no-verdict"});
  for (const int ranks : {2, 4}) expect_the_same(report_of_ranks(ranks, {"join", path("still.maps")}), one);
}

TEST_F(StoresOfRanks, ThatARankCannotJoinAreRefused) {
  ASSERT_EQ(build(2, log).exit_code, 0);
  ASSERT_EQ(call({"build", bundled("manhattan3d.g2o"), "-o", path("space.maps")}).exit_code, 0);
  ASSERT_EQ(call({"build", log, "-o", path("plane.maps"), "--poses-per-map", "20"}).exit_code, 0);
  ASSERT_EQ(call({"build", log, "-o", path("cut.maps"), "--poses-per-map", "10"}).exit_code, 0);
  std::ofstream(path("other.g2o")) << content_of(log) << "EDGE_PRIOR_XY 1000 5 5 4 0 4\n";
  ASSERT_EQ(call({"build", path("other.g2o"), "-o", path("other.maps"), "--poses-per-map", "20"}).exit_code, 0);
  const auto refused = [&](std::vector<std::string> stores, int exit_code, const char* sentence) {
    stores.insert(stores.begin(), "join");
    const Ended ended = call_ranks(2, stores);
    EXPECT_EQ(ended.exit_code, exit_code) << sentence;
    EXPECT_THAT(ended.err, HasSubstr(sentence));
  };
  refused({store(1, 2)}, 3, "its 2 portions are to be joined together, each once; there are 1 store");
  refused({store(1, 2), store(1, 2)}, 3, "there are 2 stores");
  refused({path("plane.maps"), path("space.maps")}, 3, "are not of one dimension");
  refused({path("plane.maps"), path("other.maps")}, 2, "are not of one log: `mapjoin join` takes several");
  refused({path("plane.maps"), store(1, 2)}, 2, "are not of one log");
  refused({path("plane.maps"), path("cut.maps")}, 3, "are cut in different ways");
  std::ofstream(path("small.g2o")) << kSmallLog;
  ASSERT_EQ(call({"build", path("small.g2o"), "-o", path("small.maps")}).exit_code, 0);
  refused({path("small.maps")}, 2, "too few for 2 ranks");
  refused({log}, 3, "not a mapjoin store");
  refused({path("missing.maps")}, 3, "missing.maps");
  execute_sql(path("plane.maps"), "UPDATE records SET data = x'ffffff7f' || substr(data, 5) WHERE name = 'feature_factors'");
  refused({path("plane.maps")}, 3, "damaged store");
}

TEST_F(StoresOfRanks, LeadToTheMapOfARunWithoutThem) {
  ASSERT_EQ(call_ranks(2, {"run", log, "-o", path("plain.g2o"), "--poses-per-map", "20"}).exit_code, 0);
  ASSERT_EQ(call_ranks(2, checkpointed(path("first.g2o"))).exit_code, 0);
  const auto again = report_of_ranks(2, checkpointed(path("again.g2o")));
  EXPECT_TRUE(again["local_maps"]["iterations"].is_null()) << "they were there";
  EXPECT_EQ(content_of(path("first.g2o")), content_of(path("plain.g2o")));
  EXPECT_EQ(content_of(path("again.g2o")), content_of(path("plain.g2o")));
}

TEST_F(StoresOfRanks, OfOtherOptionsAreBegunAfresh) {
  ASSERT_EQ(build(2, log, "10").exit_code, 0);
  const std::string before = content_of(store(1, 2));
  const auto report = report_of_ranks(2, checkpointed(path("map.g2o")));
  EXPECT_FALSE(report["local_maps"]["iterations"].is_null());
  EXPECT_NE(content_of(store(1, 2)), before);
}

TEST_F(StoresOfRanks, AreBegunAfreshWhereOneIsDamaged) {
  ASSERT_EQ(build(2, log).exit_code, 0);
  const std::string sound = content_of(store(2, 2));
  execute_sql(store(2, 2), "UPDATE records SET data = zeroblob(length(data)) WHERE name = 'feature_factors'");
  ASSERT_NE(content_of(store(2, 2)), sound);
  ASSERT_EQ(call_ranks(2, checkpointed(path("map.g2o"))).exit_code, 0);
  EXPECT_EQ(content_of(store(2, 2)), sound);
}

TEST_F(StoresOfRanks, OfAnotherNumberOfRanksAreRefused) {
  ASSERT_EQ(build(2, log).exit_code, 0);
  const Ended ended = call_ranks(4, checkpointed(path("map.g2o")));
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("the folder has stores of 2 ranks, and this is called on 4"));
  for (const int rank : {1, 2}) std::filesystem::rename(store(rank, 2), store(rank, 2) + ".partial");
  EXPECT_EQ(call_ranks(4, checkpointed(path("map.g2o"))).exit_code, 2) << "where none was finished, too";
}

TEST_F(StoresOfRanks, HaveNoPlaceForPosesInAnotherOrderThanTheirIds) {
  std::ofstream file(path("shuffled.g2o"));
  for (int k = 0; k < 40; ++k) file << "EDGE_SE2 " << k * 7 % 41 << ' ' << (k + 1) * 7 % 41 << " 1 0 0 1 0 0 1 0 1\n";
  file.close();
  const Ended ended = build(1, path("shuffled.g2o"));
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("not driven in the order of their ids"));
}

TEST_F(StoresOfRanks, AreNotTheLogNorTheReport) {
  std::filesystem::create_directory(path("stores"));
  for (const std::string& place : {store(2, 2), store(1, 2) + ".partial"}) {
    std::filesystem::copy(log, place);
    for (const std::vector<std::string>& wrong : {std::vector<std::string>{"build", place, "-o", path("stores")},
                                                  {"build", log, "-o", path("stores"), "--report", place},
                                                  {"run", place, "--checkpoint", path("stores")}}) {
      const Ended ended = call_ranks(2, wrong);
      EXPECT_EQ(ended.exit_code, 2);
      EXPECT_THAT(ended.err, HasSubstr(place + " is what "));
    }
    EXPECT_EQ(content_of(place), content_of(log));
  }
}

TEST_F(StoresOfRanks, NeedAFolder) {
  std::ofstream(path("stores")) << "a file\n";
  const Ended ended = build(2, log);
  EXPECT_EQ(ended.exit_code, 5);
  EXPECT_THAT(ended.err, HasSubstr("stores"));
}

}  // namespace
}  // namespace mapjoin::testing
