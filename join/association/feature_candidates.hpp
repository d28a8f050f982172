// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The features that may be the same, by the joined map of the identities known so far.

#include <Eigen/Core>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/join/association/matching/point_tree.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <vector>

namespace mapjoin {

/// A feature that another one may be the same as.
template <int Dim>
struct Candidate {
  FeatureIndex feature;
  double confusable = 0.0;      ///< Number of other features that it may be mistaken for.
  PointMatrix<Dim> covariance;  ///< Covariance of the difference of the two (m²).
};

/// The features of a map that have candidates.
template <int Dim>
struct OpenFeatures {
  std::vector<FeatureIndex> features;
  std::vector<std::vector<Candidate<Dim>>> candidates;  ///< By feature.
  std::vector<FeatureIndex> with_near;                  ///< These features and all that lie near one of them, ascending.
  Eigen::MatrixXd covariances;  ///< A row for each coordinate of `features`, a column for each of `with_near` (m²).

  /// The covariance of one of `with_near` (rows) with features[place] (columns).
  PointMatrix<Dim> covariance(FeatureIndex one, std::size_t place) const;
};

/// Finds the features that may be the same as those of a map.
template <int Dim>
class FeatureCandidates {
 public:
  /// Candidates are those within `gate`, a squared Mahalanobis distance. The references must outlive this.
  FeatureCandidates(const FeatureEstimate<Dim>& estimate, const Identities& identities, const NeighbourDensity<Dim>& density,
                    double gate);

  /// The features of a map that may be the same as others that it or a map before it sees; with `only_neighbours`, that it or
  /// the map before it sees.
  OpenFeatures<Dim> of_map(std::size_t map, bool only_neighbours) const;
  /// The chance that a local map sees a feature, by the distance of the nearest other one that it sees (m), learnt from local
  /// maps that follow each other. Features of these that may be the same tell nothing.
  SightingChance sighting_chance() const;

 private:
  std::vector<FeatureIndex> near(FeatureIndex feature, std::size_t map, bool only_neighbours) const;
  std::vector<FeatureIndex> unclear(std::size_t map) const;
  bool follows_a_local_map(std::size_t map) const;
  void add_trials(std::size_t of, std::size_t by, const std::vector<FeatureIndex>& but,
                  std::vector<SightingTrial>& trials) const;

  const FeatureEstimate<Dim>& estimate_;
  const Identities& identities_;
  const NeighbourDensity<Dim>& density_;
  double gate_;
  Table<FeatureIndex, PointMatrix<Dim>> covariances_;
  double largest_ = 0.0;  // largest trace of a covariance
  PointTree<Dim> tree_;
};

}  // namespace mapjoin
