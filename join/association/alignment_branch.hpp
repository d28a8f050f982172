// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which features of several pairs of maps are the same: one hypothesis over all of them, and what it makes of the joined map.

#include <Eigen/Core>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/hypothesis.hpp>
#include <mapjoin/join/association/map_matching.hpp>
#include <mapjoin/model/ids.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// Columns of the covariance of a joined map (m²), of the features that are asked for.
template <int Dim>
class CovarianceColumns {
 public:
  explicit CovarianceColumns(const FeatureEstimate<Dim>& estimate);

  const Point<Dim>& position(FeatureIndex feature) const { return estimate_->covariances->state().features[feature]; }
  /// Solves for the columns of features that it does not have yet.
  void add(std::span<const FeatureIndex> features);
  /// Forgets all others.
  void keep(const std::vector<FeatureIndex>& features);
  /// Of any feature with one that has its columns.
  auto between(FeatureIndex any, FeatureIndex column) const { return columns_[column].template middleRows<Dim>(offset(any)); }

 private:
  Eigen::Index offset(FeatureIndex feature) const {
    return estimate_->covariances->equations().offset(estimate_->covariances->variable(feature));
  }

  const FeatureEstimate<Dim>* estimate_;
  Table<FeatureIndex, Eigen::MatrixXd> columns_;  // empty where there are none
};

/// A pair of maps as a branch has it.
struct AlignedPair {
  std::size_t pair = 0;  ///< By its index among the pairs of maps.
  std::vector<FeaturePair> features;
  std::vector<Match> matches;  ///< Of each of them, given the others.
};

/// The joined map, given that some features are the same.
template <int Dim>
class AlignmentBranch {
 public:
  /// Pairings that tell where a map lies.
  static constexpr std::size_t kFewest = Dim + 1;

  const std::vector<FeaturePair>& held() const { return held_; }
  const std::vector<AlignedPair>& placed() const { return placed_; }
  /// The sum of squared Mahalanobis distances of where each pair of maps lies from where it was expected by those before, less
  /// its mean, and what was charged.
  double excess() const { return excess_; }

  /// L⁻¹ C of the differences of pairs, C being their covariance with what is held and L its Cholesky factor. `above` are rows
  /// of it that are known already.
  Eigen::MatrixXd coupling(std::span<const FeaturePair> differences, const CovarianceColumns<Dim>& covariances,
                           const Eigen::MatrixXd& above) const;
  /// What is expected of differences with such a coupling.
  Eigen::VectorXd expected(const Eigen::MatrixXd& coupling) const { return -coupling.transpose() * whitened_; }
  /// Features as they are expected, and how certain: the known ones, then the sightings; nothing is chosen yet.
  PairingProblem<Dim> problem(std::span<const FeatureIndex> known, std::span<const FeatureIndex> sightings,
                              const CovarianceColumns<Dim>& covariances) const;

  /// Takes a pair of maps, and holds pairings of it that lie far apart: so many that they tell its place.
  void place(AlignedPair placed, const CovarianceColumns<Dim>& covariances);
  void charge(double excess) { excess_ += excess; }

 private:
  double excess_of(const std::vector<FeaturePair>& pairs, const CovarianceColumns<Dim>& covariances) const;
  std::optional<PointMatrix<Dim>> covariance_left(const FeaturePair& pair, const Eigen::MatrixXd& coupling,
                                                  const CovarianceColumns<Dim>& covariances) const;
  void hold(const FeaturePair& pair, const CovarianceColumns<Dim>& covariances);

  std::vector<FeaturePair> held_;
  std::vector<AlignedPair> placed_;
  Eigen::MatrixXd factor_;    // L Lᵀ, the covariance of the differences that are held to be zero
  Eigen::VectorXd whitened_;  // L⁻¹ differences
  double excess_ = 0.0;
};

}  // namespace mapjoin
