// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Sightings paired with known features, and whether the pairs are compatible together.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/join/association/neighbour_density.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// A sighting and the known feature that it may be of, by their indices in a PairingProblem.
struct Pairing {
  std::size_t known = 0;
  std::size_t sighting = 0;
  bool operator==(const Pairing&) const = default;
};

/// The probability that belongs to the logarithm of odds.
inline double probability_of(double log_odds) {
  return 1.0 / (1.0 + std::exp(-log_odds));
}

/// Which sightings are of which known features? Both are points of one frame, uncertain together. No feature is sighted twice.
template <int Dim>
struct PairingProblem {
  std::vector<Point<Dim>> known;
  std::vector<Point<Dim>> sightings;
  Eigen::MatrixXd covariance;                     ///< Of all points, the known ones first (m²).
  std::vector<std::vector<std::size_t>> choices;  ///< By sighting, the known features that it may be of.
  std::vector<Point<Dim>> surroundings;  ///< All features of the map that the sightings are from, where they shift together.
  double log_tests = 0.0;                ///< The logarithm of how many such problems are tried where chance may find an answer.

  /// known - sighting, which should be zero, and its covariance with that of another pairing.
  Point<Dim> difference(const Pairing& pairing) const { return known[pairing.known] - sightings[pairing.sighting]; }
  PointMatrix<Dim> covariance_of(const Pairing& one, const Pairing& other) const;
};

/// How much a pairing adds to a hypothesis.
template <int Dim>
struct Extension {
  Pairing pairing;
  double gain = 0.0;            ///< Logarithm of the odds against another feature there that is not known yet.
  PointMatrix<Dim> covariance;  ///< Of the difference, given the pairings before it.
  Point<Dim> whitened;          ///< The difference, given them, in its standard deviations.
  Eigen::MatrixXd coupling;     ///< The rows of the Cholesky factor below the others.
  double squared_distance() const { return whitened.squaredNorm(); }
};

/// Pairings that are compatible together: the squared Mahalanobis distance of all their differences is within its gate.
template <int Dim>
class Hypothesis {
 public:
  explicit Hypothesis(const PairingProblem<Dim>& problem) : problem_(&problem), known_of_(problem.sightings.size()) {}

  const std::vector<Pairing>& pairings() const { return pairings_; }
  std::optional<std::size_t> known_of(std::size_t sighting) const { return known_of_[sighting]; }
  bool takes(std::size_t known) const;
  double score() const { return score_; }  ///< The sum of all gains.
  double squared_distance() const { return whitened_.squaredNorm(); }
  /// The squared distance less its mean, were all pairings right.
  double excess() const { return squared_distance() - static_cast<double>(whitened_.size()); }

  /// What a pairing would add; nothing where it alone or together with the others is outside of the gates.
  std::optional<Extension<Dim>> extension(const Pairing& pairing, const NeighbourDensity<Dim>& density,
                                          ChiSquaredQuantiles& gates) const;
  void extend(const Extension<Dim>& extension);
  /// By those of the pairings, in their order, that can be added.
  void extend_by(const std::vector<Pairing>& pairings, const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates);

  /// By how much the squared distance would grow, were all known features shifted.
  double growth(const Point<Dim>& shift) const;

 private:
  const PairingProblem<Dim>* problem_;
  std::vector<std::optional<std::size_t>> known_of_;
  std::vector<Pairing> pairings_;
  Eigen::MatrixXd factor_;    // L Lᵀ, the covariance of all differences
  Eigen::VectorXd whitened_;  // L⁻¹ differences
  double score_ = 0.0;
};

}  // namespace mapjoin
