// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Leave-one-out tests of how well sightings fit the features that they were given.

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <vector>

namespace mapjoin {

/// The test of a map's measurement of a feature, which other maps see, too, against everything else. If the map is observations
/// on their own, the measurement is one of these.
struct SightingTest {
  std::size_t map = 0;
  FeatureIndex feature;
  double chi2 = 0.0;  ///< Squared Mahalanobis distance, chi-square with as many degrees of freedom as dimensions.
};

/// Leave-one-out tests of the features that several maps see: those of observations on their own, then those of local maps,
/// each in the order of the maps.
template <int Dim>
std::vector<SightingTest> tests_of(const FeatureEstimate<Dim>& estimate, const Identities& identities);

/// The factor by which covariances are too small: the median of the tests over its expectation, at least 1; 1 if there are few
/// tests.
double overconfidence_of(const std::vector<SightingTest>& tests, int dimensions);

/// The worst test of each feature that has one beyond the gate.
std::vector<SightingTest> misfits(const std::vector<SightingTest>& tests, double gate);

}  // namespace mapjoin
