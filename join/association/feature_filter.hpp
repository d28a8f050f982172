// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Features as the robot has them around it: a Kalman filter in the frame of its present pose.

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

  /// The robot moves on along one step of odometry, in either direction of the edge.
  void move(const PoseFactor<Dim>& step);
  /// Adds what was seen for the first time.
  void add(const FeatureFactor<Dim>& observation);
  /// Takes an observation of a feature, by its index.
  void update(std::size_t feature, const FeatureFactor<Dim>& observation);

 private:
  static Eigen::Index row(std::size_t feature) { return static_cast<Eigen::Index>(feature) * Dim; }

  std::vector<Point<Dim>> features_;
  Eigen::MatrixXd covariance_;
};

}  // namespace mapjoin
