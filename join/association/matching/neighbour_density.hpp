// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The density of features around a feature, learnt from points seen at once.

#include <mapjoin/geometry/pose.hpp>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// The density of other features around a feature, by its mean over discs of any radius (Ripley's K-function). Points that one
/// pose or one local map sees at once are different features: trees hardly ever stand half a metre apart, so that a sighting so
/// near to a known tree is hardly of another one.
template <int Dim>
class NeighbourDensity {
 public:
  /// Each set holds points of different features, in any frame (m). Their errors have the covariance `noise` (m²), zero if it
  /// is not known: features in a plane, or on a line, count as spread across it by so much.
  explicit NeighbourDensity(std::span<const std::vector<Point<Dim>>> sets,
                            const PointMatrix<Dim>& noise = PointMatrix<Dim>::Zero());

  /// The logarithm of the density (1/m to the power of Dim) of other features at a point that is this far from a feature (m²)
  /// and has this variance along each axis (m²): its mean over a normal distribution about the feature with the same mean
  /// square. One pair more is counted than was seen; the density is at most overall().
  double log_within(double squared_distance, double variance) const;
  double overall() const { return overall_; }
  /// The number of other features that one may be mistaken for, per √det of the covariance of the difference (1/m to the power
  /// of Dim).
  double confusable_per_deviation() const;
  /// Takes another density over all features around, of which the sets show a share: a sensor may give one feature at a time,
  /// or overlook many. The density at every distance is then as many times higher.
  void set_overall(double overall);

 private:
  std::vector<double> distances_;  // between all pairs of points of a set, ascending (m); of many sets, of some of them
  double points_ = 0.0;            // number of points of these sets, but for those of one point
  double overall_ = 0.0;           // density over whole sets
  double share_ = 1.0;             // of the features around that is seen at once
};

/// The density of points (1/m to the power of Dim) over sets with errors of covariance `noise`, as in NeighbourDensity: that of
/// all sets of Dim + 2 points or more; if there are none, of all sets laid over each other. nullopt if these are too few, or
/// fill nothing.
template <int Dim>
std::optional<double> mean_density(std::span<const std::vector<Point<Dim>>> sets, const PointMatrix<Dim>& noise);

}  // namespace mapjoin
