// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A Kalman filter of the features around the robot, in the frame of its present pose.

#include <Eigen/Core>
#include <mapjoin/model/factor.hpp>
#include <vector>

namespace mapjoin {

/// A Gaussian over features in the frame of the present pose, where observations are linear: there is no pose to estimate.
template <int Dim>
class FeatureFilter {
 public:
  const std::vector<Point<Dim>>& features() const { return features_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// Predicts the features in the frame of the next pose, along an edge of odometry in either direction.
  void move(const PoseFactor<Dim>& step);
  /// Adds a feature by its first observation.
  void add(const FeatureFactor<Dim>& observation);
  /// Updates the features with an observation of one of them, by its index.
  void update(std::size_t feature, const FeatureFactor<Dim>& observation);

 private:
  static Eigen::Index row(std::size_t feature) { return static_cast<Eigen::Index>(feature) * Dim; }

  std::vector<Point<Dim>> features_;
  Eigen::MatrixXd covariance_;
};

}  // namespace mapjoin
