// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Naming in words what the observations leave free to move.

#include <Eigen/Core>
#include <mapjoin/geometry/pose.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// A pose or a feature as it stands, and where its entries are among those of the system.
template <int Dim>
struct PlacedVariable {
  std::string name;
  Pose<Dim> value;           ///< Of a feature the translation.
  Eigen::Index offset = -1;  ///< -1 where it is held.
  bool is_pose = true;
};

/// The directions of a null space, a column each, as a sentence: "pose 5 and pose 6 cannot be determined: the observations
/// leave them free to turn as a whole about feature 7". Directions that have variables in common are named together; three such
/// parts of the map at most. Empty where the null space is.
template <int Dim>
std::string free_directions(const std::vector<PlacedVariable<Dim>>& variables, const Eigen::MatrixXd& null_space);

}  // namespace mapjoin
