// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Description in words of the directions that the observations leave free.

#include <Eigen/Core>
#include <mapjoin/geometry/pose.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// A pose or a feature at its estimate, and the place of its entries in the system.
template <int Dim>
struct PlacedVariable {
  std::string name;
  Pose<Dim> value;           ///< Pose, or the position of a feature as its translation.
  Eigen::Index offset = -1;  ///< First entry in the system; -1 if held.
  bool is_pose = true;
};

/// The largest distance of a variable from the first one, the unit in which lengths compare with angles (m); 1 if all are at
/// one place.
template <int Dim>
double extent_of(const std::vector<PlacedVariable<Dim>>& variables);

/// The directions of a null space, a column each, as a sentence: "pose 5 and pose 6 cannot be determined: the observations
/// leave them free to turn as a whole about feature 7". Directions that have variables in common are named together, at most
/// three such parts of the map. Empty if the null space is.
template <int Dim>
std::string free_directions(std::vector<PlacedVariable<Dim>> variables, Eigen::MatrixXd null_space);

}  // namespace mapjoin
