// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A map in relative form (paper's (22), (33)): every pose and feature in the frame of its parent.
//
// Parents are those of the spanning tree of the whole map: in a log, the parent of a pose is the pose before it and that of a
// feature the pose that observed it first; with local maps it is the start of the map that holds the child. Relations can be
// far more certain than positions, as errors add up along the tree.

#include <mapjoin/join/restored.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin {

/// A pose in the frame of its parent, with the covariance of its step there: translation (m), then rotation on the right (rad).
template <int Dim>
struct PoseRelation {
  PoseIndex parent = kWorld;  ///< A pose, or the World.
  Pose<Dim> value;
  PoseMatrix<Dim> covariance = PoseMatrix<Dim>::Zero();  ///< Zero if the pose is anchored.
};

/// A feature in the frame of its parent (m).
template <int Dim>
struct FeatureRelation {
  PoseIndex parent = kWorld;
  Point<Dim> value = Point<Dim>::Zero();
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();
};

/// The relations of a map, by the indices of poses and features.
template <int Dim>
struct Relations {
  Table<PoseIndex, PoseRelation<Dim>> poses;
  Table<FeatureIndex, FeatureRelation<Dim>> features;
  std::vector<PoseIndex> order;  ///< All poses, each after its parent.
};

/// The estimate of a whole map in relative form, without covariances.
template <int Dim>
Relations<Dim> relations_of(const Restored<Dim>& restored);

/// The map composed from its relations.
template <int Dim>
Values<Dim> composed(const Relations<Dim>& relations);

/// ∂(child in the frame of parent)/∂(parent, child).
template <int Dim>
Matrix<kPoseDof<Dim>, 2 * kPoseDof<Dim>> J_relation(const Pose<Dim>& parent, const Pose<Dim>& child) {
  PoseMatrix<Dim> J_parent;
  PoseMatrix<Dim> J_child;
  between(parent, child, &J_parent, &J_child);
  return (Matrix<kPoseDof<Dim>, 2 * kPoseDof<Dim>>() << J_parent, J_child).finished();
}
template <int Dim>
Matrix<Dim, kPoseDof<Dim> + Dim> J_relation(const Pose<Dim>& parent, const Point<Dim>& child) {
  PointPoseMatrix<Dim> J_parent;
  PointMatrix<Dim> J_child;
  transform_into<Dim>(parent, child, &J_parent, &J_child);
  return (Matrix<Dim, kPoseDof<Dim> + Dim>() << J_parent, J_child).finished();
}

}  // namespace mapjoin
