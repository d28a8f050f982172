// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The state vector: every pose and feature in one frame (paper's (8), (30)).

#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
struct State {
  std::vector<Pose<Dim>> poses;
  std::vector<Point<Dim>> features;  ///< (m)

  /// The pose by its index; the World is the origin.
  Pose<Dim> pose(Index index) const { return index == kWorld ? Pose<Dim>{} : poses[static_cast<std::size_t>(index)]; }
  const Point<Dim>& feature(Index index) const { return features[static_cast<std::size_t>(index)]; }
};

/// `state` seen from another frame: every pose and feature moved by `frame`.
template <int Dim>
State<Dim> moved(const Pose<Dim>& frame, State<Dim> state) {
  for (auto& pose : state.poses) pose = compose(frame, pose);
  for (auto& feature : state.features) feature = transform(frame, feature);
  return state;
}

}  // namespace mapjoin
