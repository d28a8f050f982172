// SPDX-License-Identifier: BSD-3-Clause
// Public data sets associated with their ids hidden, scored by pairs of sightings.
#include <gtest/gtest.h>

#include <iostream>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/run.hpp>
#include <set>
#include <tests/support/data.hpp>
#include <tests/support/large_simulation.hpp>
#include <tests/support/pair_score.hpp>

namespace mapjoin {
namespace {

struct HiddenData {
  std::string path;
  double precision;
  double recall;
};

void PrintTo(const HiddenData& hidden, std::ostream* out) {
  *out << hidden.path;
}

std::vector<AssociatedSighting> sightings_found(const std::filesystem::path& path) {
  if (!may_hold_maps(path)) return associate(std::get<Log<2>>(open_log(path).value()), AssociationOptions{}).value().sightings;
  return associate(std::get<SubmapSet<2>>(open_maps(path).value()), AssociationOptions{}).value().sightings;
}

std::size_t features_of(const std::vector<AssociatedSighting>& sightings) {
  std::set<FeatureId> features;
  for (const AssociatedSighting& s : sightings) features.insert(s.joined);
  return features.size();
}

class HiddenNames : public ::testing::TestWithParam<HiddenData> {};

TEST_P(HiddenNames, AreFound) {
  const auto sightings = sightings_found(testing::data_file(GetParam().path));
  const testing::PairScore score = testing::pair_score(sightings);
  std::cout << GetParam().path << ": sightings " << sightings.size() << ", features " << features_of(sightings)
            << ", precision " << score.precision << ", recall " << score.recall << '\n';
  EXPECT_GE(score.precision, GetParam().precision);
  EXPECT_GE(score.recall, GetParam().recall);
}

INSTANTIATE_TEST_SUITE_P(Data, HiddenNames,
                         ::testing::Values(HiddenData{"sim-535/local_maps", 0.99, 0.99},
                                           HiddenData{"vicpark-200-local-maps", 0.99, 0.97},
                                           HiddenData{"vicpark-6898/VicPark_clean_data.mat", 0.99, 0.97},
                                           HiddenData{"dlr-200-local-maps", 0.9, 0.9},
                                           HiddenData{"dlr/corrected_data_circles.mat", 0.9, 0.9}));

/// Features on a regular grid, seen from a drive that crosses itself sixty times.
TEST(HiddenNamesOfTheLargeSimulation, AreFoundAndTheMapIsAsCertainAsItSays) {
  const auto set = std::get<SubmapSet<2>>(open_maps(testing::data_file("sim-35188/localmaps_mat.tar.gz")).value());
  auto found = associate(set, AssociationOptions{}).value();
  const testing::PairScore score = testing::pair_score(found.sightings);
  std::cout << "features " << found.data.features.size() << ", precision " << score.precision << ", recall " << score.recall
            << '\n';
  EXPECT_GE(score.precision, 0.99);
  EXPECT_GE(score.recall, 0.99);
  const Truth<2> by_name = testing::truth_of_simulation(set);
  Truth<2> truth{by_name.poses, {}};
  truth.features.resize(found.data.features.size());
  const IndexOf named(set.features);
  const IndexOf joined(found.data.features);
  for (const AssociatedSighting& s : found.sightings) truth.features[*joined(s.joined)] = by_name.features[*named(s.name)];
  RunOptions options;
  options.covariances = true;
  const auto result = run(std::move(found.data), options).value();
  const Consistency consistent = consistency(*result.covariances, truth).value();
  std::cout << "NEES of poses and features together " << consistent.joint.value << '\n';
  for (const Nees& nees : {consistent.poses, consistent.features, consistent.joint}) EXPECT_LT(nees.value, nees.most());
}

}  // namespace
}  // namespace mapjoin
