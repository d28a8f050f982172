// SPDX-License-Identifier: BSD-3-Clause
// Public data cut into sessions that share no ids of features: association finds common features, and by them how sessions lie.
#include <gtest/gtest.h>

#include <map>
#include <mapjoin/io/merged_logs.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <set>
#include <tests/support/cut_log.hpp>
#include <tests/support/cut_maps.hpp>
#include <tests/support/data.hpp>
#include <tests/support/pair_score.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin::testing {
namespace {

/// Pairs of trees of citytrees that stand at one place.
using Twins = std::pair<std::uint64_t, std::uint64_t>;
const std::vector<Twins> kTwins = {{2, 34}, {4, 91}, {5, 86}, {12, 78}, {45, 77}, {46, 57}, {62, 99}, {67, 88}};

struct Hidden {
  std::string path;
  std::size_t sessions;
  bool names_hold;
};
void PrintTo(const Hidden& hidden, std::ostream* out) {
  *out << hidden.path << " in " << hidden.sessions << (hidden.names_hold ? ", own names" : ", no names");
}

/// The pairs of sessions with at least `least` features in common, told apart by `name`.
template <typename Name>
std::set<std::pair<std::uint32_t, std::uint32_t>> pairs_sharing(const std::vector<AssociatedSighting>& sightings,
                                                                std::size_t least, Name name) {
  std::map<std::uint64_t, std::set<std::uint32_t>> sessions;
  for (const AssociatedSighting& s : sightings) sessions[name(s)].insert(s.base.session);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> count;
  for (const auto& [feature, by] : sessions) {
    for (const std::uint32_t a : by) {
      for (const std::uint32_t b : by) {
        if (a < b) ++count[{a, b}];
      }
    }
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const auto& [pair, features] : count) {
    if (features >= least) pairs.insert(pair);
  }
  return pairs;
}

class UnknownFrames : public ::testing::TestWithParam<Hidden> {};

/// The associated sightings of data cut into sessions without common ids; `step` becomes the distance of a session's ids from
/// those of the one before.
std::vector<AssociatedSighting> sightings_found(const Hidden& hidden, std::uint64_t& step) {
  const auto path = data_file(hidden.path);
  AssociationOptions options;
  options.names_hold = hidden.names_hold;
  if (!may_hold_maps(path)) {
    const auto log = std::get<Log<2>>(open_log(path).value());
    std::vector<Log<2>> logs;
    for (std::size_t k = 0; k < hidden.sessions; ++k) logs.push_back(cut_session(log, k, hidden.sessions));
    step = step_apart(log.features.back().key, hidden.sessions).value();
    return associate(merged(std::move(logs), {.own_features = true}).value(), options).value().sightings;
  }
  const auto set = std::get<SubmapSet<2>>(open_maps(path).value());
  step = step_apart(set.features.back().key, hidden.sessions).value();
  const TemporaryFolder folder;
  const auto folders = cut_maps(set, hidden.sessions, folder.path());
  const auto maps = open_several_maps(folders, {}, {.own_features = true}).value();
  return associate(std::get<SubmapSet<2>>(maps), options).value().sightings;
}

TEST_P(UnknownFrames, AreFoundByFeatures) {
  std::uint64_t step = 1;
  auto sightings = sightings_found(GetParam(), step);
  const auto twins = GetParam().path.starts_with("citytrees") ? kTwins : std::vector<Twins>();
  for (AssociatedSighting& s : sightings) {
    s.name.key %= step;
    const auto twin = std::ranges::find(twins, s.name.key, &Twins::second);
    if (twin != twins.end()) s.name.key = twin->first;
  }
  const PairScore score = pair_score(sightings);
  std::cout << "precision " << score.precision << ", recall " << score.recall << '\n';
  EXPECT_GE(score.precision, 0.99);
  const auto joined = pairs_sharing(sightings, 4, [](const AssociatedSighting& s) { return s.joined.key; });
  for (const auto& pair : pairs_sharing(sightings, 8, [](const AssociatedSighting& s) { return s.name.key; })) {
    EXPECT_TRUE(joined.contains(pair)) << "sessions " << pair.first << " and " << pair.second;
  }
}

/// Beacons of a regular grid, which look the same everywhere.
TEST(UnknownFrames, OfARegularGridStayApart) {
  const auto set = std::get<SubmapSet<2>>(open_maps(data_file("sim-35188/localmaps_mat.tar.gz")).value());
  const TemporaryFolder folder;
  const auto maps = open_several_maps(cut_maps(set, 2, folder.path()), {}, {.own_features = true}).value();
  AssociationOptions options;
  options.names_hold = true;
  const auto found = associate(std::get<SubmapSet<2>>(maps), options).value();
  ASSERT_EQ(found.untied.size(), 1u);
  EXPECT_EQ(found.untied.front().alignment.status, AlignmentStatus::kAmbiguous);
}

/// The cases, without citytrees with no ids at all, which takes minutes.
std::vector<Hidden> cases() {
  std::vector<Hidden> all;
  for (const std::string path : {"vicpark-6898/VicPark_clean_data.mat", "dlr/corrected_data_circles.mat",
                                 "citytrees10000/cityTrees10000.txt", "vicpark-200-local-maps", "dlr-200-local-maps"}) {
    for (const std::size_t sessions : {3U, 10U}) all.push_back({path, sessions, true});
    if (!path.starts_with("citytrees")) all.push_back({path, 5U, false});
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Data, UnknownFrames, ::testing::ValuesIn(cases()));

}  // namespace
}  // namespace mapjoin::testing
