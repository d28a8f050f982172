// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// One hypothesis on which features of several pairs of maps are the same, and the joined map given that hypothesis.

#include <Eigen/Core>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <mapjoin/join/association/matching/hypothesis.hpp>
#include <mapjoin/model/ids.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// Columns of the covariance of a joined map (m²), for requested features only.
template <int Dim>
class CovarianceColumns {
 public:
  explicit CovarianceColumns(const FeatureEstimate<Dim>& estimate);

  const Point<Dim>& position(FeatureIndex feature) const { return estimate_->position(feature); }
  /// Solves for those columns of the features that are missing.
  void add(std::span<const FeatureIndex> features);
  /// Drops the columns of all other features.
  void keep(const std::vector<FeatureIndex>& features);
  /// The covariance of any feature (rows) with one whose columns are present (m²).
  auto between(FeatureIndex any, FeatureIndex column) const { return columns_[column].template middleRows<Dim>(offset(any)); }

 private:
  Eigen::Index offset(FeatureIndex feature) const {
    return estimate_->covariances->equations().offset(estimate_->covariances->variable(feature));
  }

  const FeatureEstimate<Dim>* estimate_;
  Table<FeatureIndex, Eigen::MatrixXd> columns_;  // by feature; empty if not present
};

/// A pair of maps, with the pairings, at least one, by which a branch aligns them.
struct AlignedPair {
  std::size_t pair = 0;  ///< Index among the pairs of maps.
  std::vector<FeaturePair> features;
  std::vector<Match> matches;  ///< The match of each of `features`, given the others; the score of each is the alignment's.
};

/// The joined map, given that some features are the same.
template <int Dim>
class AlignmentBranch {
 public:
  /// The least number of pairings that are taken to determine where a map lies.
  static constexpr std::size_t kFewest = Dim + 1;

  const std::vector<FeaturePair>& held() const { return held_; }
  const std::vector<AlignedPair>& placed() const { return placed_; }
  /// The sum over placed pairs of maps of the squared Mahalanobis distance between their alignment and the one predicted by the
  /// pairs before, less its mean, plus all charges.
  double excess() const { return excess_; }
  /// The sum over placed pairs of maps of the logarithm of the odds of their alignment (see Matcher::log_odds()).
  double log_odds() const { return log_odds_; }

  /// L⁻¹ C, with C the covariance of the held differences with the differences of pairs, and L the Cholesky factor of the
  /// covariance of the held ones. `above` are the first rows of the result, if known already.
  Eigen::MatrixXd coupling(std::span<const FeaturePair> differences, const CovarianceColumns<Dim>& covariances,
                           const Eigen::MatrixXd& above) const;
  /// The change of differences with this coupling that the held ones imply.
  Eigen::VectorXd expected(const Eigen::MatrixXd& coupling) const { return -coupling.transpose() * whitened_; }
  /// The conditional means and covariance of features, the known ones first, then the sightings; choices are still empty.
  PairingProblem<Dim> problem(std::span<const FeatureIndex> known, std::span<const FeatureIndex> sightings,
                              const CovarianceColumns<Dim>& covariances) const;

  /// Adds an aligned pair of maps, and holds up to kFewest of its pairings, far apart, so that they determine the alignment.
  void place(AlignedPair placed, const CovarianceColumns<Dim>& covariances);
  void charge(double excess) { excess_ += excess; }

 private:
  double excess_of(const std::vector<FeaturePair>& pairs, const CovarianceColumns<Dim>& covariances) const;
  std::optional<PointMatrix<Dim>> covariance_left(const FeaturePair& pair, const Eigen::MatrixXd& coupling,
                                                  const CovarianceColumns<Dim>& covariances) const;
  void hold(const FeaturePair& pair, const CovarianceColumns<Dim>& covariances);

  std::vector<FeaturePair> held_;
  std::vector<AlignedPair> placed_;
  Eigen::MatrixXd factor_;    // L, with L Lᵀ the covariance of the differences that are held at zero
  Eigen::VectorXd whitened_;  // L⁻¹ times the held differences
  double excess_ = 0.0;
  double log_odds_ = 0.0;
};

}  // namespace mapjoin
