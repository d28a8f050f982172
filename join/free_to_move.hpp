// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the observations of a join leave free to move, in words.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/model/ids.hpp>
#include <string>

namespace mapjoin {

/// The largest number of null-space directions that are examined if a system is singular.
inline constexpr std::size_t kMostFreeDirections = 60;

/// The names of the poses or features of a part of the map, by place.
template <typename Index, typename Id>
Table<Index, Id> names_at(const Table<Index, Index>& part, const Table<Index, Id>& names) {
  Table<Index, Id> by_place;
  by_place.reserve(part.size());
  for (const Index index : part) by_place.push_back(names[index]);
  return by_place;
}

/// A sentence on the poses and features that the observations of a singular system leave free to move, in the directions of its
/// null space, a column each, with advice if the largest weights leave no digits to the least. `singular` is the variable to
/// name if there are no directions. The names are those of the places of the joined state.
template <int Dim>
std::string free_to_move(const JoiningSystem<Dim>& system, Variable singular, const Eigen::MatrixXd& null_space,
                         const PoseIds& pose_ids, const FeatureIds& feature_ids);

}  // namespace mapjoin
