// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/join/association/sighting_fit.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// The fewest tests whose median tells anything about the covariances.
constexpr std::size_t kFewestTests = 20;

}  // namespace

template <int Dim>
std::vector<SightingTest> tests_of(const FeatureEstimate<Dim>& estimate, const Identities& identities) {
  const JoiningSystem<Dim>& system = estimate.restored->system;
  const NormalEquations& equations = estimate.covariances->equations();
  const LeaveOneOut<Dim> leave_one_out(system, equations, *estimate.marginals);
  std::vector<std::size_t> map_of_factor;
  for (std::size_t map = 0; map < estimate.is_local_map.size(); ++map) {
    if (estimate.is_local_map[map]) map_of_factor.push_back(map);
  }
  std::vector<std::size_t> map_of_observation;  // observations of their own are in the order of their sightings
  for (std::size_t s = 0; s < identities.sighting_count(); ++s) {
    if (const std::size_t map = identities.sighting(s).map; !estimate.is_local_map[map]) map_of_observation.push_back(map);
  }
  const auto is_shared = [&](FeatureIndex f) {
    const auto sightings = identities.sightings_of(f);
    return identities.sighting(sightings.front()).map != identities.sighting(sightings.back()).map;
  };
  std::vector<std::vector<SightingTest>> of_factors(equations.pattern().factors.size());
  parallel_for(of_factors.size(), [&](std::size_t factor) {
    const auto [kind, place] = system.source_of(factor);
    const auto add = [&](std::size_t map, FeatureIndex feature, Eigen::Index row) {
      if (!is_shared(feature)) return;
      const PartTest test = leave_one_out.test({factor, row, Dim});
      if (test.rows == Dim) of_factors[factor].push_back({map, feature, test.chi2});
    };
    if (kind == JoiningSystem<Dim>::Source::kPoseFactor) return;
    if (kind == JoiningSystem<Dim>::Source::kFeatureFactor) {
      add(map_of_observation[place], system.feature_factors()[place].observation->target, 0);
      return;
    }
    const LocalMap<Dim>& map = *system.maps()[place].map;
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      add(map_of_factor[place], map.features[f], map.row(map.poses.size() + f));
    }
  });
  std::vector<SightingTest> tests;
  for (const auto& some : of_factors) tests.insert(tests.end(), some.begin(), some.end());
  return tests;
}

double overconfidence_of(const std::vector<SightingTest>& tests, int dimensions) {
  if (tests.size() < kFewestTests) return 1.0;
  std::vector<double> distances;
  for (const SightingTest& test : tests) distances.push_back(test.chi2);
  return std::max(1.0, median(std::move(distances)) / chi_squared_quantile(0.5, dimensions));
}

std::vector<SightingTest> misfits(const std::vector<SightingTest>& tests, double gate) {
  std::map<FeatureIndex, SightingTest> worst;
  for (const SightingTest& test : tests) {
    if (test.chi2 <= gate) continue;
    const auto [of_feature, is_first] = worst.emplace(test.feature, test);
    if (!is_first && of_feature->second.chi2 < test.chi2) of_feature->second = test;
  }
  std::vector<SightingTest> found;
  for (const auto& [feature, test] : worst) found.push_back(test);
  return found;
}

template std::vector<SightingTest> tests_of(const FeatureEstimate<2>&, const Identities&);
template std::vector<SightingTest> tests_of(const FeatureEstimate<3>&, const Identities&);

}  // namespace mapjoin
