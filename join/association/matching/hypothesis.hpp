// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Hypotheses: jointly compatible pairings of sightings with known features.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/join/association/matching/neighbour_density.hpp>
#include <mapjoin/join/association/matching/sighting_chance.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <optional>
#include <vector>

namespace mapjoin {

/// A sighting and the known feature matched with it, by their indices in a PairingProblem.
struct Pairing {
  std::size_t known = 0;
  std::size_t sighting = 0;
  bool operator==(const Pairing&) const = default;
};

/// The probability for a logarithm of odds.
inline double probability_of(double log_odds) {
  return 1.0 / (1.0 + std::exp(-log_odds));
}

/// One of two maps that are matched: its features, to tell which of them the other map should have seen, or how the map falls
/// onto itself.
template <int Dim>
struct MatchedMap {
  std::vector<Point<Dim>> all;       ///< All that the map sees (m).
  std::vector<Point<Dim>> unpaired;  ///< Those that can be none of the other map's (m).
};

/// The problem of matching sightings with known features: points of one frame with a joint covariance. No feature is sighted
/// twice.
template <int Dim>
struct PairingProblem {
  std::vector<Point<Dim>> known;
  std::vector<Point<Dim>> sightings;
  Eigen::MatrixXd covariance;                     ///< Joint covariance of all points, the known ones first (m²).
  std::vector<std::vector<std::size_t>> choices;  ///< Known features that a sighting may be of, by sighting.
  const SightingChance* sees = nullptr;           ///< The chance that a pose sees a feature; null if that is not known.
  /// By known feature, its distances (m) from the pose that saw it last and from that of the sightings: if a sighting is of
  /// another feature there, they overlooked one of the two. Empty without `sees`.
  std::vector<std::array<double, 2>> distances;
  std::array<MatchedMap<Dim>, 2> maps;  ///< Those of the known features and of the sightings, if these are two; else empty.
  /// The chance that a map sees a feature, by the distance of the nearest other one that it sees (m); null if that is not
  /// known.
  const SightingChance* map_sees = nullptr;
  double log_tests = 0.0;  ///< Logarithm of the number of such problems tried, if chance may solve one; else 0.

  /// known - sighting (m), which should be zero; covariance_of() is its covariance with that of another pairing (m²).
  Point<Dim> difference(const Pairing& pairing) const { return known[pairing.known] - sightings[pairing.sighting]; }
  PointMatrix<Dim> covariance_of(const Pairing& one, const Pairing& other) const;
  /// The first row of a point in `covariance`.
  Eigen::Index row_of_known(std::size_t point) const { return static_cast<Eigen::Index>(point) * Dim; }
  Eigen::Index row_of_sighting(std::size_t point) const { return row_of_known(known.size() + point); }
  /// The logarithm of the chance that a feature was overlooked from all distances of a known one, each known to ± `error` (m).
  double log_overlooked(std::size_t known, double error) const;
};

/// Points of a PairingProblem, by their indices.
struct KnownAndSightings {
  std::vector<std::size_t> known;
  std::vector<std::size_t> sightings;
};

/// A pairing that can be added to a hypothesis, and its gain.
template <int Dim>
struct Extension {
  Pairing pairing;
  double gain = 0.0;            ///< Logarithm of the odds against another feature there that is not known yet.
  PointMatrix<Dim> covariance;  ///< Covariance of the difference, given the pairings before it (m²).
  Point<Dim> whitened;          ///< The difference, given the pairings before it, in standard deviations.
  Eigen::MatrixXd coupling;     ///< The new rows of the Cholesky factor below the others, transposed.
  double squared_distance() const { return whitened.squaredNorm(); }
};

/// What the pairings of a hypothesis leave of the difference of another one.
template <int Dim>
struct Remainder {
  Point<Dim> difference = Point<Dim>::Zero();              ///< Given the pairings (m).
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();  ///< Of the difference (m²).
};

/// The extension, without its coupling, of a hypothesis of `rows` coordinates in all and squared distance `d2` by a pairing of
/// which it leaves `left`; nullopt if the distance of the pairing, or that of all together, is outside of its gate.
template <int Dim>
std::optional<Extension<Dim>> extension_by(const Pairing& pairing, const Remainder<Dim>& left, Eigen::Index rows, double d2,
                                           const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates);

/// A pairing of a hypothesis, given all others.
template <int Dim>
struct GivenOthers {
  /// Logarithm of the odds against another feature there that is not known yet: one of the two was then overlooked from each of
  /// the problem's distances. Other pairings that without this one are more probably of other features would fall with it, and
  /// their gains count, too.
  double gain = 0.0;
  PointMatrix<Dim> covariance;  ///< Covariance of the difference, given the other pairings (m²).
};

/// The growth of the squared distance of a hypothesis if all known features are shifted, which it is called with.
template <int Dim>
struct ShiftGrowth {
  PointMatrix<Dim> information;  ///< Of a shift (1/m²).
  Point<Dim> slope;              ///< Half the gradient at no shift (1/m).
  double operator()(const Point<Dim>& shift) const { return shift.dot(information * shift + 2.0 * slope); }
};

/// Pairings that are jointly compatible: the squared Mahalanobis distance of all their differences is within its gate.
template <int Dim>
class Hypothesis {
 public:
  explicit Hypothesis(const PairingProblem<Dim>& problem) : problem_(&problem), known_of_(problem.sightings.size()) {}

  const std::vector<Pairing>& pairings() const { return pairings_; }
  std::optional<std::size_t> known_of(std::size_t sighting) const { return known_of_[sighting]; }
  bool takes(std::size_t known) const;
  double score() const { return score_; }  ///< The sum of all gains.
  double squared_distance() const { return whitened_.squaredNorm(); }
  /// The squared distance less its mean if all pairings are right.
  double excess() const { return squared_distance() - static_cast<double>(whitened_.size()); }

  /// The extension by a pairing; nullopt if its distance given the others, or that of all together, is outside of its gate.
  std::optional<Extension<Dim>> extension(const Pairing& pairing, const NeighbourDensity<Dim>& density,
                                          ChiSquaredQuantiles& gates) const;
  void extend(const Extension<Dim>& extension);
  /// Each of pairings(), given the others; nullopt if its distance given these is outside of its gate. O(n³) for n pairings, if
  /// few fall with others.
  std::vector<std::optional<GivenOthers<Dim>>> given_others(const NeighbourDensity<Dim>& density,
                                                            ChiSquaredQuantiles& gates) const;
  /// The points that are neither paired nor among the choices by which the hypothesis could be extended.
  KnownAndSightings without_partner(const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates) const;
  /// Extends the hypothesis by those of the pairings, in their order, that can be added.
  void extend_by(const std::vector<Pairing>& pairings, const NeighbourDensity<Dim>& density, ChiSquaredQuantiles& gates);

  ShiftGrowth<Dim> growth() const;

 private:
  const PairingProblem<Dim>* problem_;
  std::vector<std::optional<std::size_t>> known_of_;
  std::vector<Pairing> pairings_;
  Eigen::MatrixXd factor_;    // L, with L Lᵀ the covariance of all differences
  Eigen::VectorXd whitened_;  // L⁻¹ times the differences
  double score_ = 0.0;
};

}  // namespace mapjoin
