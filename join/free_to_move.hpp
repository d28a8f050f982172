// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the observations of a join leave free to move: found where rounding hides it, and in words.

#include <Eigen/Core>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/model/ids.hpp>
#include <optional>
#include <string>
#include <vector>

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

/// True if observations and maps of full rank tie every pose to the World or an anchored pose, and every feature to one of
/// these or a pose: nothing is then free to move. `fits` are those of the system's maps, in their order.
template <int Dim>
bool is_surely_determined(const JoiningSystem<Dim>& system, const std::vector<MapFit>& fits);

/// What the observations of a joining system leave free to move.
struct Freedom {
  std::optional<Variable> singular;  ///< A variable whose pivot is singular, if the factorisation met one.
  Eigen::MatrixXd directions;        ///< A column each; none where the engine's pivot alone is singular.

  bool is_any() const { return singular.has_value() || directions.size() > 0; }
};

/// The freedom of `system`, in which factorise() met a singular pivot at `singular`.
template <int Dim>
Freedom freedom_at(Variable singular, const JoiningSystem<Dim>& system);

/// The freedom of `system`, which was factorised near its estimate, without damping and without a singular pivot. A direction
/// that no pivot shows at the estimate, either, is found alone: the pivot of one along which many poses move far, such as a
/// turn of the whole map, is a difference of large sums, whose rounding passes for information.
///
/// Inverse iteration leads to the direction v that costs least by the factorised H. Its cost is the sum of (J v)ᵀ W (J v) over
/// the factors, which does not suffer from cancellation; v is free if it is no larger than that of the rounding of J v.
template <int Dim>
Freedom hidden_freedom(JoiningSystem<Dim>& system);

/// A sentence on the poses and features that have some freedom, with advice if the largest weights leave no digits to the
/// least. The names are those of the places of the joined state.
template <int Dim>
std::string free_to_move(const JoiningSystem<Dim>& system, const Freedom& freedom, const PoseIds& pose_ids,
                         const FeatureIds& feature_ids);

}  // namespace mapjoin
