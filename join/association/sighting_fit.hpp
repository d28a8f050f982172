// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Do sightings fit the features that they were given?

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <vector>

namespace mapjoin {

/// What a map says of a feature that other maps see, too, against what all others say.
struct SightingTest {
  std::size_t map = 0;
  FeatureIndex feature;
  double chi2 = 0.0;  ///< Squared Mahalanobis distance, chi-square with as many degrees of freedom as dimensions.
};

/// Leave-one-out tests of the features of local maps, in the order of the maps.
template <int Dim>
std::vector<SightingTest> tests_of(const FeatureEstimate<Dim>& estimate, const Identities& identities);

/// By how much covariances are too sure: the median of the tests over what it should be, at least 1, and 1 where there are few.
double overconfidence_of(const std::vector<SightingTest>& tests, int dimensions);

/// The worst test of each feature that has one beyond the gate.
std::vector<SightingTest> misfits(const std::vector<SightingTest>& tests, double gate);

}  // namespace mapjoin
