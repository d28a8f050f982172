// SPDX-License-Identifier: BSD-3-Clause
// The stores of ranks: what goes on from them, and what joins them.
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
  const Ended twice = call({"join", store(2, 2), store(2, 2)});
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
}

TEST_F(StoresOfRanks, HaveNoPlaceForPosesInAnotherOrderThanTheirIds) {
  std::ofstream file(path("shuffled.g2o"));
  for (int k = 0; k < 40; ++k) file << "EDGE_SE2 " << k * 7 % 41 << ' ' << (k + 1) * 7 % 41 << " 1 0 0 1 0 0 1 0 1\n";
  file.close();
  const Ended ended = build(1, path("shuffled.g2o"));
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("not driven in the order of their ids"));
}

TEST_F(StoresOfRanks, NeedAFolder) {
  std::ofstream(path("stores")) << "a file\n";
  const Ended ended = build(2, log);
  EXPECT_EQ(ended.exit_code, 5);
  EXPECT_THAT(ended.err, HasSubstr("stores"));
}

}  // namespace
}  // namespace mapjoin::testing
