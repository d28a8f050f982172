// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The state vector: every pose and feature in one frame (paper's (8), (30)).

#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
struct Values {
  std::vector<Pose<Dim>> poses;
  std::vector<Point<Dim>> features;  ///< (m)

  /// The pose by its index; the World is the origin.
  Pose<Dim> pose(Index index) const { return index == kWorld ? Pose<Dim>{} : poses[static_cast<std::size_t>(index)]; }
  const Point<Dim>& feature(Index index) const { return features[static_cast<std::size_t>(index)]; }
};

/// Puts the values of a part into the state of the whole: `poses` and `features` are its indices there.
template <int Dim>
void write_values(const Values<Dim>& part, const std::vector<Index>& poses, const std::vector<Index>& features,
                  Values<Dim>& whole) {
  for (std::size_t p = 0; p < poses.size(); ++p) whole.poses[static_cast<std::size_t>(poses[p])] = part.poses[p];
  for (std::size_t f = 0; f < features.size(); ++f) whole.features[static_cast<std::size_t>(features[f])] = part.features[f];
}

/// `state` seen from another frame: every pose and feature moved by `frame`.
template <int Dim>
Values<Dim> moved(const Pose<Dim>& frame, Values<Dim> state) {
  for (auto& pose : state.poses) pose = compose(frame, pose);
  for (auto& feature : state.features) feature = transform(frame, feature);
  return state;
}

}  // namespace mapjoin
