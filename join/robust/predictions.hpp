// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a map says of relative poses that nothing in it ties together.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <vector>

namespace mapjoin {

/// Predictions of closures by a map that they have no part in.
///
/// The covariance between two poses is that of either with a landing place, a pose beside one of them, whose columns of H⁻¹
/// are kept: P_ij ≈ P_ib P_bb⁻¹ P_bj, which is exact where b separates i from j.
template <int Dim>
class Predictions {
 public:
  /// By `most` landing places or fewer, spread over the poses of `system`, all of which are in its order. By the last
  /// factorisation of its equations; all must stay.
  Predictions(const JoiningSystem<Dim>& system, const Marginals& marginals, std::size_t most);

  /// The measured less the predicted relative pose; its covariance is that of retract()'s steps from the identity.
  UncertainPose<Dim> mismatch(const PoseFactor<Dim>& closure) const;

 private:
  PoseMatrix<Dim> columns(PoseIndex pose, std::size_t place) const;

  const JoiningSystem<Dim>& system_;
  std::vector<PoseIndex> places_;
  Table<PoseIndex, PoseMatrix<Dim>> covariances_;
  Eigen::MatrixXd columns_;
};

}  // namespace mapjoin
