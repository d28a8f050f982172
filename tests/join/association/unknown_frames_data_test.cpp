// SPDX-License-Identifier: BSD-3-Clause
// Public data cut into sessions that share no names: which features are the same, and so where the sessions lie, is found out.
#include <gtest/gtest.h>

#include <map>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/model/merged_logs.hpp>
#include <set>
#include <tests/support/cut_log.hpp>
#include <tests/support/data.hpp>
#include <tests/support/pair_score.hpp>

namespace mapjoin::testing {
namespace {

/// Trees of citytrees that stand at one place.
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

/// Pairs of sessions with at least so many features in common, as `name` has them.
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

TEST_P(UnknownFrames, AreFoundByFeatures) {
  const auto& [path, sessions, names_hold] = GetParam();
  const auto log = std::get<Log<2>>(open_log(data_file(path)).value());
  std::vector<Log<2>> logs;
  for (std::size_t k = 0; k < sessions; ++k) logs.push_back(cut_session(log, k, sessions));
  const std::uint64_t step = step_apart(log.features.back().key, sessions).value();
  AssociationOptions options;
  options.names_hold = names_hold;
  const auto twins = path.starts_with("citytrees") ? kTwins : std::vector<Twins>();
  auto found = associate(merged(std::move(logs), {.own_features = true}).value(), options).value();
  for (AssociatedSighting& s : found.sightings) {
    s.name.key %= step;
    const auto twin = std::ranges::find(twins, s.name.key, &Twins::second);
    if (twin != twins.end()) s.name.key = twin->first;
  }
  const PairScore score = pair_score(found.sightings);
  EXPECT_GE(score.precision, 0.99);
  const auto joined = pairs_sharing(found.sightings, 4, [](const AssociatedSighting& s) { return s.joined.key; });
  for (const auto& pair : pairs_sharing(found.sightings, 8, [](const AssociatedSighting& s) { return s.name.key; })) {
    EXPECT_TRUE(joined.contains(pair)) << "sessions " << pair.first << " and " << pair.second;
  }
}

std::vector<Hidden> cases() {
  std::vector<Hidden> all;
  for (const std::string path :
       {"vicpark-6898/VicPark_clean_data.mat", "dlr/corrected_data_circles.mat", "citytrees10000/cityTrees10000.txt"}) {
    for (const std::size_t sessions : {2U, 3U, 5U, 10U}) {
      for (const bool names_hold : {false, true}) all.push_back({path, sessions, names_hold});
    }
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Data, UnknownFrames, ::testing::ValuesIn(cases()));

}  // namespace
}  // namespace mapjoin::testing
