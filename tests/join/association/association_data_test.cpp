// SPDX-License-Identifier: BSD-3-Clause
// The public data sets with their ids hidden, counted by pairs of sightings.
#include <gtest/gtest.h>

#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <tests/support/data.hpp>
#include <tests/support/pair_score.hpp>

namespace mapjoin {
namespace {

struct Hidden {
  std::string path;
  double precision;
  double recall;
};

void PrintTo(const Hidden& hidden, std::ostream* out) {
  *out << hidden.path;
}

std::vector<AssociatedSighting> sightings_found(const std::filesystem::path& path) {
  if (!may_hold_maps(path)) return associate(std::get<Log<2>>(open_log(path).value()), AssociationOptions{}).value().sightings;
  return associate(std::get<SubmapSet<2>>(open_maps(path).value()), AssociationOptions{}).value().sightings;
}

class HiddenNames : public ::testing::TestWithParam<Hidden> {};

TEST_P(HiddenNames, AreFound) {
  const testing::PairScore score = testing::pair_score(sightings_found(testing::data_file(GetParam().path)));
  EXPECT_GE(score.precision, GetParam().precision);
  EXPECT_GE(score.recall, GetParam().recall);
}

INSTANTIATE_TEST_SUITE_P(Data, HiddenNames,
                         ::testing::Values(Hidden{"sim-535/local_maps", 0.99, 0.99},
                                           Hidden{"vicpark-200-local-maps", 0.99, 0.97},
                                           Hidden{"vicpark-6898/VicPark_clean_data.mat", 0.99, 0.97},
                                           Hidden{"dlr-200-local-maps", 0.9, 0.9},
                                           Hidden{"dlr/corrected_data_circles.mat", 0.9, 0.9}));

}  // namespace
}  // namespace mapjoin
