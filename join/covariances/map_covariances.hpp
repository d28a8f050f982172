// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The uncertainty of a global map: covariances of poses and features, alone, together, and relative to each other.
//
// A covariance is that of the step of a variable: for a pose the translation in the frame of the map (m), then the rotation as
// a rotation vector on the right (rad); for a feature the position (m). It is relative to the gauge: that of a constant pose is
// zero.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <mapjoin/join/covariances/relations.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// The estimate about which every observation is linearised.
enum class Estimate : std::uint8_t {
  kJoined,    ///< The joined map: of local maps by their Gaussians, of a log with its interiors recovered.
  kPolished,  ///< The refined map: the least chi2 of every observation of the log.
};

constexpr auto enum_names(Estimate) {
  return std::to_array<EnumName<Estimate>>({{Estimate::kJoined, "joined"}, {Estimate::kPolished, "polished"}});
}

template <int Dim>
struct MarginalCovariances {
  Table<PoseIndex, PoseMatrix<Dim>> poses;         ///< Covariance of each pose; zero if it is constant.
  Table<FeatureIndex, PointMatrix<Dim>> features;  ///< Covariance of each feature (m²).
  Relations<Dim> relations;                        ///< The map in relative form.
};

/// Covariances of a whole map, blocks of the inverse of its information, from its factor; owns all that it needs. Errors of its
/// functions: kTooLarge, before memory is allocated, if they need more than there may be; bad input if the information is
/// singular.
template <int Dim>
class MapCovariances {
 public:
  /// Linearises `restored` at its estimate, factorises, and moves its normal equations out. `most_memory` is in bytes, 0 for
  /// that of the machine.
  static Expected<MapCovariances> make(Restored<Dim>& restored, Estimate estimate, std::int64_t most_memory = 0);

  Estimate estimate() const { return estimate_; }
  /// The normal equations at the estimate, over the variables that variable() gives.
  const NormalEquations& equations() const { return equations_; }
  /// The estimate of all poses and features of the map.
  const Values<Dim>& state() const { return state_; }
  /// The gauge: constant poses, ascending; empty if priors hold the map.
  const std::vector<PoseIndex>& anchored() const { return anchored_; }
  /// The variable of a pose or feature; kConstant if it is constant, as the World is, or nothing observes it.
  Variable variable(PoseIndex pose) const { return pose == kWorld ? kConstant : pose_variables_[pose]; }
  Variable variable(FeatureIndex feature) const { return feature_variables_[feature]; }

  /// The covariances of every variable, and of all that one observation ties together, at about twice the cost of the
  /// factorisation. `progress` is called with the supernodes done and to do; kInterrupted on `stop`. The result owns all that
  /// it needs.
  Expected<Marginals> on_pattern(const std::function<void(std::size_t, std::size_t)>& progress = nullptr,
                                 const std::stop_token& stop = {}) const;
  /// The covariances of every pose and feature, in the map and relative to their parents.
  MarginalCovariances<Dim> marginals(const Marginals& on_pattern) const;
  /// The marginals if nothing else needs on_pattern(), whose arguments these are.
  Expected<MarginalCovariances<Dim>> marginals(const std::function<void(std::size_t, std::size_t)>& progress = nullptr,
                                               const std::stop_token& stop = {}) const {
    return on_pattern(progress, stop).map([&](const Marginals& all) { return marginals(all); });
  }
  /// The joint covariance of `variables`, in their order (kPoseDof<Dim> rows a pose, Dim rows a feature); the World is a pose
  /// whose rows are zero. Bad input if the map has no such pose or feature.
  Expected<Eigen::MatrixXd> joint(std::span<const PoseOrFeature> variables) const;
  /// The covariance of a pose in the frame of another, that of a step of between(base, target). Errors as joint().
  Expected<PoseMatrix<Dim>> relative_pose(PoseIndex base, PoseIndex target) const;
  /// The covariance of a feature in the frame of a pose (m²). Errors as joint().
  Expected<PointMatrix<Dim>> relative_feature(PoseIndex base, FeatureIndex feature) const;
  /// The covariance in the frame of `base`, from the joint covariance of both, the base's rows first.
  PoseMatrix<Dim> relative_pose(PoseIndex base, PoseIndex target, const Matrix<2 * kPoseDof<Dim>>& of_both) const;
  PointMatrix<Dim> relative_feature(PoseIndex base, FeatureIndex feature, const Matrix<kPoseDof<Dim> + Dim>& of_both) const;

 private:
  MapCovariances(Restored<Dim>& restored, Estimate estimate, std::int64_t most_memory);
  bool has(PoseIndex pose) const { return pose == kWorld || indices(pose_variables_).contains(pose); }
  bool has(FeatureIndex feature) const { return indices(feature_variables_).contains(feature); }
  /// The joint covariance of a parent, a pose or the World, and its child, which one observation ties together; the rows of a
  /// constant parent are zero.
  template <int ChildDof, typename Child>
  Matrix<kPoseDof<Dim> + ChildDof> with_parent(PoseIndex parent, Child child, const Marginals& marginals) const;

  NormalEquations equations_;
  Estimate estimate_;
  std::int64_t most_memory_;
  Values<Dim> state_;
  std::vector<PoseIndex> anchored_;
  Table<PoseIndex, Variable> pose_variables_;
  Table<FeatureIndex, Variable> feature_variables_;
  Relations<Dim> relations_;  // without covariances
};

}  // namespace mapjoin
