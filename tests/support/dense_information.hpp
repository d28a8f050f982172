// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The dense information matrix of all observations, with nothing eliminated, to compare covariances with its inverse.

#include <Eigen/Core>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin::testing {

/// A dense information matrix over poses, then features.
template <int Dim>
class DenseInformation {
 public:
  explicit DenseInformation(const Values<Dim>& state);

  void add(const PoseFactor<Dim>& o);
  void add(const FeatureFactor<Dim>& o);
  void add(const LocalMap<Dim>& map);
  /// Adds a quadratic form over these entries of the state.
  void add(const std::vector<Eigen::Index>& rows, const Eigen::MatrixXd& information);

  const Eigen::MatrixXd& information() const { return H_; }
  Eigen::Index pose_row(PoseIndex pose) const { return pose == kWorld ? -1 : pose.value * kPoseDof<Dim>; }
  Eigen::Index feature_row(FeatureIndex feature) const { return pose_row(indices(state_.poses).last) + feature.value * Dim; }

  /// The covariance with some poses held, whose rows are zero; inverted in extended precision, to be more exact than what is
  /// compared with it.
  Eigen::MatrixXd inverse(const std::vector<PoseIndex>& held) const;
  /// The covariance in coordinates y of as many entries, T = ∂x/∂y, with the same poses held in x and y; their rows are zero.
  Eigen::MatrixXd inverse(const std::vector<PoseIndex>& held, const Eigen::MatrixXd& T) const;

 private:
  using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

  std::vector<Eigen::Index> free_rows(const std::vector<PoseIndex>& held) const;
  Eigen::MatrixXd inverse(const std::vector<Eigen::Index>& free, const Extended& H) const;

  const Values<Dim>& state_;
  Eigen::MatrixXd H_;
};

}  // namespace mapjoin::testing
