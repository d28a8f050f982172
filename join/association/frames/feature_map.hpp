// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The features of a joined map in its own frame, to be aligned with another map of unknown frame, and their constellations:
// features with neighbours that look alike in two maps.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <vector>

namespace mapjoin {

/// Features with their joint covariance, and the positions of the poses from which they were seen.
template <int Dim>
struct FeatureMap {
  std::vector<Point<Dim>> features;
  Eigen::MatrixXd covariance;  ///< Joint covariance of all features, in their order (m²).
  std::vector<Point<Dim>> poses;

  /// The covariance between two features.
  PointMatrix<Dim> covariance_of(std::size_t i, std::size_t k) const {
    return covariance.template block<Dim, Dim>(static_cast<Eigen::Index>(i) * Dim, static_cast<Eigen::Index>(k) * Dim);
  }
  /// The covariance of the vector from one feature to another.
  PointMatrix<Dim> relative_covariance(std::size_t i, std::size_t k) const {
    const PointMatrix<Dim> C = covariance_of(i, k);
    return covariance_of(i, i) + covariance_of(k, k) - C - C.transpose();
  }
  /// The variance of the distance between two features.
  double variance_of_distance(std::size_t i, std::size_t k) const {
    const Point<Dim> direction = (features[k] - features[i]).stableNormalized();
    return std::max(0.0, direction.dot(relative_covariance(i, k) * direction));
  }
};

/// The map of some features of an estimate, in their order, with its covariances times its scale; `poses` is empty. Errors as
/// of MapCovariances::joint().
template <int Dim>
Expected<FeatureMap<Dim>> feature_map_of(const FeatureEstimate<Dim>& estimate, const std::vector<FeatureIndex>& features) {
  const std::vector<PoseOrFeature> all(features.begin(), features.end());
  return estimate.covariances->joint(all).map([&](const Eigen::MatrixXd& covariance) {
    FeatureMap<Dim> map{{}, estimate.scale * covariance, {}};
    for (const FeatureIndex f : features) map.features.push_back(estimate.position(f));
    return map;
  });
}

/// A feature and some of its neighbours: pairings of features of a first map (known) with those of a second one (sightings),
/// the feature itself first.
using Constellation = std::vector<Pairing>;

/// The constellations that look alike in both maps, of at least four features.
///
/// Triangles of a feature and two of its nearest neighbours are found in the other map by the lengths of their sides (a k-d
/// tree), within what the covariances allow with probability `confidence`. If several triangles around two features agree on
/// which neighbour is which, the largest clique of them is a constellation. Triangles that look like very many others, as in a
/// regular plantation, are compared with only some of these.
template <int Dim>
std::vector<Constellation> constellations_alike(const FeatureMap<Dim>& first, const FeatureMap<Dim>& second, double confidence);

}  // namespace mapjoin
