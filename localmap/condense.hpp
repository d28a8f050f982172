// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Private features, seen in one local map only: eliminated before joining and recovered after it, exactly.

#include <Eigen/Core>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/state.hpp>
#include <vector>

namespace mapjoin {

/// A local map without its private features. These enter (31) linearly in the frame of the base, so the joined map of the
/// others is the same.
template <int Dim>
struct CondensedMap {
  LocalMap<Dim> map;  ///< W_oo - W_of W_ff⁻¹ W_fo over what stays.
  std::vector<Index> private_features;
  std::vector<Point<Dim>> private_estimates;  ///< In the frame of the base (m).
  Eigen::MatrixXd gain;  ///< W_ff⁻¹ W_fo: the residuals of the private features are -gain · those of the others.
  Eigen::MatrixXd private_information;  ///< W_ff, of the private features given the others.
};

/// `is_private` is per feature. Where they are not determined within the map, all stay.
template <int Dim>
CondensedMap<Dim> condense(LocalMap<Dim> map, const std::vector<bool>& is_private);

/// The map as it was, its private features behind the others.
template <int Dim>
LocalMap<Dim> uncondensed(const CondensedMap<Dim>& condensed);

/// Puts the private features where they lower chi2 most, given the joined poses and features in `state`.
template <int Dim>
void recover_private_features(const CondensedMap<Dim>& condensed, State<Dim>& state);

/// Per feature: whether one map alone mentions it, and no observation or prior.
template <int Dim>
std::vector<bool> private_features(const std::vector<LocalMap<Dim>>& maps, std::vector<bool> mentioned_elsewhere);

}  // namespace mapjoin
