// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The variables of a join, and the coordinates of its steps.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <mapjoin/solve/trust_region.hpp>
#include <vector>

namespace mapjoin {

enum class JoinedState : std::uint8_t {
  kAbsolute,  ///< Poses and features in the frame of the map (paper's (30)).
  kRelative,  ///< Each relative to its parent in the spanning tree (paper's (33)).
};

constexpr auto enum_names(JoinedState) {
  return std::to_array<EnumName<JoinedState>>({{JoinedState::kAbsolute, "absolute"}, {JoinedState::kRelative, "relative"}});
}

/// The variables of a joined state: first the poses that are not anchored, then the features, by place. Vectors hold their
/// entries in this order.
template <int Dim>
class StateVariables {
 public:
  StateVariables(std::size_t poses, std::size_t features, const std::vector<PoseIndex>& anchored) : of_pose_(poses) {
    for (const PoseIndex place : anchored) of_pose_[place] = kConstant;
    for (const PoseIndex place : indices(of_pose_)) {
      if (of_pose_[place] == kConstant) continue;
      of_pose_[place] = Variable(places_.size());
      places_.emplace_back(place);
    }
    first_feature_ = Variable(places_.size());
    for (FeatureIndex place = 0; place.position() < features; ++place) places_.emplace_back(place);
  }

  /// The variable at a place; kConstant for the World and for anchored poses.
  Variable operator()(PoseIndex place) const { return place == kWorld ? kConstant : of_pose_[place]; }
  Variable operator()(FeatureIndex place) const { return first_feature_ + place.value; }
  Variable operator()(const PoseOrFeature& placed) const {
    return std::visit([&](auto place) { return (*this)(place); }, placed);
  }
  PoseOrFeature place(Variable variable) const { return places_[variable]; }

  int dof(Variable variable) const { return variable < first_feature_ ? kPoseDof<Dim> : Dim; }
  /// The first entry of a variable in vectors.
  Eigen::Index offset(Variable variable) const {
    const Variable pose = std::min(variable, first_feature_);
    return Eigen::Index{kPoseDof<Dim>} * pose.value + Eigen::Index{Dim} * (variable - pose);
  }
  /// The length of vectors.
  Eigen::Index size() const { return offset(Variable(places_.size())); }
  Table<Variable, int> dofs() const {
    Table<Variable, int> dofs(first_feature_.position(), kPoseDof<Dim>);
    dofs.resize(places_.size(), Dim);
    return dofs;
  }

  /// The state moved by a step.
  Values<Dim> retracted(Values<Dim> state, const Eigen::Ref<const Eigen::VectorXd>& step) const {
    parallel_chunks(state.poses.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
      for (PoseIndex place(begin); place < PoseIndex(end); ++place) {
        const Variable variable = of_pose_[place];
        if (variable == kConstant) continue;
        state.poses[place] = retract<Dim>(state.poses[place], step.template segment<kPoseDof<Dim>>(offset(variable)));
      }
    });
    const Eigen::Index first = offset(first_feature_);
    for (const FeatureIndex f : indices(state.features)) state.features[f] += step.template segment<Dim>(first + f.value * Dim);
    return state;
  }
  /// The largest translation and rotation of a variable in a step.
  StepSize step_size(const Eigen::Ref<const Eigen::VectorXd>& step) const {
    StepSize size;
    for (const Variable v : indices(places_)) {
      const Eigen::Index entry = offset(v);
      size.metres = std::max(size.metres, step.template segment<Dim>(entry).norm());
      if (v >= first_feature_) continue;
      size.radians = std::max(size.radians, step.template segment<kRotationDof<Dim>>(entry + Dim).norm());
    }
    return size;
  }

 private:
  Table<PoseIndex, Variable> of_pose_;
  Variable first_feature_ = 0;
  Table<Variable, PoseOrFeature> places_;
};

}  // namespace mapjoin
