// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/study/convexity_states.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin {
namespace {

/// The step between two rotations; headings are real numbers.
RotationVector<2> difference(const Rotation<2>& from, const Rotation<2>& to) {
  return RotationVector<2>(to.angle() - from.angle());
}
RotationVector<3> difference(const Rotation<3>& from, const Rotation<3>& to) {
  return (from.inverse() * to).log();
}

template <int Dim>
PoseVector<Dim> difference(const Pose<Dim>& from, const Pose<Dim>& to) {
  PoseVector<Dim> delta;
  delta << to.translation - from.translation, difference(from.rotation, to.rotation);
  return delta;
}

/// True if the relation goes from the child to the parent, as the observation does, which is linear in it only so.
bool is_from_child(const TreeEdge<PoseIndex>& edge) {
  return edge.observation && edge.observation->child_is_base;
}

}  // namespace

template <int Dim>
Values<Dim> unwrapped_near(Values<Dim> state, const Values<Dim>& reference) {
  for (const PoseIndex p : indices(state.poses)) {
    const Rotation<Dim>& near = reference.poses[p].rotation;
    state.poses[p].rotation = near * Rotation<Dim>::exp((near.inverse() * state.poses[p].rotation).log());
  }
  return state;
}

template <int Dim>
Values<Dim> on_line(const Values<Dim>& X, const Values<Dim>& Y, double lambda) {
  Values<Dim> state = Y;
  for (const PoseIndex p : indices(state.poses)) {
    state.poses[p] = retract<Dim>(Y.poses[p], lambda * difference(Y.poses[p], X.poses[p]));
  }
  for (const FeatureIndex f : indices(state.features)) state.features[f] += lambda * (X.features[f] - Y.features[f]);
  return state;
}

template <int Dim>
RelativeCoordinates<Dim>::RelativeCoordinates(const JoiningSystem<Dim>& system, const Values<Dim>& reference)
    : tree_(spanning_tree(system)), anchored_(reference) {
  // The measured relation or, without an observation, its value in the reference.
  for (const auto& edge : tree_.poses) {
    const Pose<Dim> near = relation(edge, reference);
    // The measured rotation, its heading within half a turn of the reference's.
    poses_.push_back(edge.observation ? retract(near, local(near, measured_pose(system, *edge.observation).value)) : near);
  }
  for (const auto& edge : tree_.features) {
    const Point<Dim> near = transform_into(reference.pose(edge.parent), reference.features[edge.child]);
    features_.push_back(edge.observation ? measured_point(system, *edge.observation).value : near);
  }
}

template <int Dim>
Pose<Dim> RelativeCoordinates<Dim>::relation(const TreeEdge<PoseIndex>& edge, const Values<Dim>& state) const {
  const Pose<Dim> parent = state.pose(edge.parent);
  const Pose<Dim> child = state.pose(edge.child);
  return is_from_child(edge) ? between(child, parent) : between(parent, child);
}

template <int Dim>
Eigen::VectorXd RelativeCoordinates<Dim>::of(const Values<Dim>& state) const {
  Eigen::VectorXd coordinates(size());
  for (std::size_t e = 0; e < tree_.poses.size(); ++e) {
    coordinates.segment<kPoseDof<Dim>>(pose_entry(e)) = difference(poses_[e], relation(tree_.poses[e], state));
  }
  for (const auto& edge : tree_.features) {
    coordinates.segment<Dim>(feature_entry(edge.child)) =
        transform_into(state.pose(edge.parent), state.features[edge.child]) - features_[edge.child];
  }
  return coordinates;
}

template <int Dim>
Values<Dim> RelativeCoordinates<Dim>::composed(const Eigen::VectorXd& coordinates) const {
  Values<Dim> state = anchored_;
  for (std::size_t e = 0; e < tree_.poses.size(); ++e) {
    const auto& edge = tree_.poses[e];
    const Pose<Dim> relation = retract<Dim>(poses_[e], coordinates.segment<kPoseDof<Dim>>(pose_entry(e)));
    state.poses[edge.child] = compose(state.pose(edge.parent), is_from_child(edge) ? inverse(relation) : relation);
  }
  for (const auto& edge : tree_.features) {
    const Point<Dim> relation = features_[edge.child] + coordinates.segment<Dim>(feature_entry(edge.child));
    state.features[edge.child] = transform(state.pose(edge.parent), relation);
  }
  return state;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                \
  template Values<Dim> unwrapped_near(Values<Dim>, const Values<Dim>&);         \
  template Values<Dim> on_line(const Values<Dim>&, const Values<Dim>&, double); \
  template class RelativeCoordinates<Dim>;
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
