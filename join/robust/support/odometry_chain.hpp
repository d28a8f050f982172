// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Dead reckoning with its covariance: how odometry alone relates any two poses of a session, in constant time.

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <numbers>
#include <vector>

namespace mapjoin {

/// The volume of all rotations (rad, rad³).
template <int Dim>
inline constexpr double kVolumeOfRotations = Dim == 2 ? 2.0 * std::numbers::pi : 8.0 * std::numbers::pi* std::numbers::pi;

/// The square of a whole turn (rad²): rotations of this variance or more are not measured.
inline constexpr double kSquaredTurn = 4.0 * std::numbers::pi * std::numbers::pi;

/// A relative pose T = Exp(ξ) T̂ with the covariance of ξ, a twist (translation, then rotation) in the frame of the base. In
/// this form covariances add up along a chain: that of a product a b is Σ_a + Ad(a) Σ_b Ad(a)ᵀ (to first order).
template <int Dim>
struct UncertainPose {
  Pose<Dim> mean;
  PoseMatrix<Dim> covariance = PoseMatrix<Dim>::Zero();
};

/// The adjoint matrix Ad of a pose: T Exp(ξ) = Exp(Ad ξ) T.
template <int Dim>
PoseMatrix<Dim> adjoint(const Pose<Dim>& pose);
template <int Dim>
UncertainPose<Dim> compose(const UncertainPose<Dim>& a, const UncertainPose<Dim>& b);
template <int Dim>
UncertainPose<Dim> inverse(const UncertainPose<Dim>& a);
/// The inverse of the information of an observation; large, but finite, in directions that it does not measure.
template <int Size>
Matrix<Size> covariance_of(const Matrix<Size>& information) {
  constexpr double kLeastInformation = 1e-9;  // share that is added to each diagonal entry; of the largest one if not measured
  constexpr double kRounding = 1e-13;         // share of the largest entry below which a row is not measured
  Matrix<Size> W = information;
  const double most = W.diagonal().maxCoeff();
  const auto is_measured = W.diagonal().array() > kRounding * most;
  const auto added = is_measured.select(W.diagonal().array(), most > 0.0 ? most : 1.0).eval();
  W.diagonal().array() += kLeastInformation * added;
  return W.llt().solve(Matrix<Size>::Identity());
}
/// The information that poses are some `extent` (m) apart and some turn: as good as nothing within the map, but in its units.
template <int Dim>
PoseVector<Dim> information_within(double extent);
/// An edge that measures only part of a relative pose, with information_within() an extent (m) added. Other edges as they are.
template <int Dim>
PoseFactor<Dim> completed(PoseFactor<Dim> edge, double extent);
/// The relative pose that an observation measures, with its covariance.
template <int Dim>
UncertainPose<Dim> uncertain(const PoseFactor<Dim>& observation);
/// The measurement of an edge, turned to lead from its earlier pose to its later one.
template <int Dim>
UncertainPose<Dim> forwards(const PoseFactor<Dim>& edge);
/// The fusion of two independent measurements of one relative pose, weighted by their information (to first order).
template <int Dim>
UncertainPose<Dim> fused(const UncertainPose<Dim>& a, const UncertainPose<Dim>& b);

/// The poses of a log as its odometry composes them, each session from the origin on; edges that repeat others are fused.
template <int Dim>
class OdometryChain {
 public:
  explicit OdometryChain(const Log<Dim>& log);

  std::size_t pose_count() const { return poses_.size(); }
  /// True if odometry connects two poses.
  bool is_tied(PoseIndex a, PoseIndex b) const { return sessions_[a] == sessions_[b]; }
  /// The pose `target` in the frame of `base`, with its covariance; they must be tied.
  UncertainPose<Dim> relative(PoseIndex base, PoseIndex target) const;
  /// The volume of relative poses between poses of the log: the box around the largest session (m, at least 1 along every axis)
  /// times all rotations.
  double volume() const;
  /// The longest side of the boxes around sessions (m, at least 1).
  double extent() const;

 private:
  std::vector<Eigen::AlignedBox<double, Dim>> boxes() const;  // around the positions of each session

  Table<PoseIndex, std::size_t> sessions_;
  Table<PoseIndex, UncertainPose<Dim>> poses_;  // in the frame of the first pose of the session
};

}  // namespace mapjoin
