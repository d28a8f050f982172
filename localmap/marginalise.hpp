// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Submap-local features, seen in one local map only: eliminated before joining and recovered after it, exactly.

#include <Eigen/Core>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin {

/// A local map without its submap-local features, which enter (31) linearly in the frame of the base, so that the joined map of
/// the others is the same.
template <int Dim>
struct MarginalisedMap {
  LocalMap<Dim> map;  ///< Its information is W_oo - W_of W_ff⁻¹ W_fo over the other targets.
  std::vector<FeatureIndex> local_features;
  std::vector<Point<Dim>> local_estimates;  ///< In the frame of the base (m).
  Eigen::MatrixXd gain;  ///< W_ff⁻¹ W_fo: the residuals of the submap-local features are -gain · those of the others.
  Eigen::MatrixXd local_information;  ///< W_ff, of the submap-local features given the others.
};

/// Eliminates the submap-local features of a map; all stay if they are not determined within the map.
template <int Dim>
MarginalisedMap<Dim> marginalise(LocalMap<Dim> map, const Table<FeatureIndex, bool>& is_local);

/// The map before marginalise(), with its submap-local features behind the others.
template <int Dim>
LocalMap<Dim> restored(const MarginalisedMap<Dim>& marginalised);

/// Sets the submap-local features to where chi2 is least, given the joined poses and features in `state`.
template <int Dim>
void recover_local_features(const MarginalisedMap<Dim>& marginalised, Values<Dim>& state);

/// True for each feature that one map alone mentions, and no observation or prior.
template <int Dim>
Table<FeatureIndex, bool> local_features(const std::vector<LocalMap<Dim>>& maps,
                                         Table<FeatureIndex, bool> referenced_elsewhere);

}  // namespace mapjoin
