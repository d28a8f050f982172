// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The state vector: every pose and feature in one frame (paper's (8), (30)).

#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>

namespace mapjoin {

template <int Dim>
struct Values {
  Table<PoseIndex, Pose<Dim>> poses;
  Table<FeatureIndex, Point<Dim>> features;  ///< (m)

  /// The pose by its index; the World is the origin.
  Pose<Dim> pose(PoseIndex index) const { return index == kWorld ? Pose<Dim>{} : poses[index]; }
};

/// Writes the values of a part into the state of the whole; `poses` and `features` are their indices there.
template <int Dim>
void write_values(const Values<Dim>& part, const Table<PoseIndex, PoseIndex>& poses,
                  const Table<FeatureIndex, FeatureIndex>& features, Values<Dim>& whole) {
  for (const PoseIndex p : indices(poses)) whole.poses[poses[p]] = part.poses[p];
  for (const FeatureIndex f : indices(features)) whole.features[features[f]] = part.features[f];
}

/// `state` with every pose and feature moved by `frame`.
template <int Dim>
Values<Dim> moved(const Pose<Dim>& frame, Values<Dim> state) {
  for (auto& pose : state.poses) pose = compose(frame, pose);
  for (auto& feature : state.features) feature = transform(frame, feature);
  return state;
}

}  // namespace mapjoin
