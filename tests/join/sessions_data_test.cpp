// SPDX-License-Identifier: BSD-3-Clause
// Public data cut into sessions: logs in random frames with pose ids of their own, or folders of local maps. Tied by the ids of
// features, logs have the optimum of the whole log without the edges between sessions.
#include <gtest/gtest.h>

#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/run.hpp>
#include <tests/support/ceres_reference.hpp>
#include <tests/support/cut_log.hpp>
#include <tests/support/cut_maps.hpp>
#include <tests/support/data.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

struct Cut {
  std::string path;
  std::size_t sessions;
};
void PrintTo(const Cut& cut, std::ostream* out) {
  *out << cut.path << " in " << cut.sessions;
}

class SessionsOfALog : public ::testing::TestWithParam<Cut> {};

TEST_P(SessionsOfALog, HaveTheOptimumOfTheWholeLessTheCuts) {
  const auto& [path, sessions] = GetParam();
  const auto log = std::get<Log<2>>(open_log(data_file(path)).value());
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (std::size_t k = 0; k < sessions; ++k) {
    files.push_back(folder.path() / (std::to_string(k) + ".g2o"));
    ASSERT_TRUE(write_log(cut_session(log, k, sessions), LogFormat::kG2o, files.back()));
  }
  const auto result = run(std::get<Log<2>>(open_logs(files).value()), without_verdict());
  ASSERT_TRUE(result) << result.error().message;
  const auto& joined = *result;
  EXPECT_TRUE(joined.converged());
  const auto ceres = ceres_optimum(without_cut_edges(log, sessions), Values<2>{joined.map.poses, joined.map.features});
  EXPECT_NEAR(joined.chi2, ceres.chi2, 1e-6 * ceres.chi2);
  EXPECT_NEAR(joined.chi2, ceres.initial_chi2, 1e-6 * ceres.chi2) << "both weigh the same measurements";
}

std::vector<Cut> cuts(const std::vector<std::string>& paths) {
  std::vector<Cut> all;
  for (const std::string& path : paths) {
    for (const std::size_t sessions : {2U, 3U, 5U, 10U}) {
      const bool falls_apart = path.starts_with("dlr/") && sessions == 10;  // five of ten share no feature with the others
      if (!falls_apart) all.push_back({path, sessions});
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Data, SessionsOfALog,
                         ::testing::ValuesIn(cuts({"vicpark-6898/VicPark_clean_data.mat", "dlr/corrected_data_circles.mat",
                                                   "citytrees10000/cityTrees10000.txt"})));

class SessionsOfLocalMaps : public ::testing::TestWithParam<Cut> {};

TEST_P(SessionsOfLocalMaps, AreJoinedToTheOptimumThatCeresFinds) {
  const auto& [path, sessions] = GetParam();
  const auto whole = std::get<SubmapSet<2>>(open_maps(data_file(path)).value());
  const TemporaryFolder folder;
  const auto set = std::get<SubmapSet<2>>(open_several_maps(cut_maps(whole, sessions, folder.path())).value());
  EXPECT_EQ(set.graph.submaps.size(), whole.graph.submaps.size());
  const auto joined = run(set, without_verdict()).value();
  EXPECT_TRUE(joined.converged());
  const auto ceres = ceres_optimum(set, Values<2>{joined.map.poses, joined.map.features});
  EXPECT_NEAR(joined.chi2, ceres.chi2, 1e-6 * ceres.chi2);
}
INSTANTIATE_TEST_SUITE_P(Data, SessionsOfLocalMaps,
                         ::testing::ValuesIn(cuts({"vicpark-200-local-maps", "dlr-200-local-maps",
                                                   "sim-35188/localmaps_mat.tar.gz"})));

}  // namespace
}  // namespace mapjoin::testing
