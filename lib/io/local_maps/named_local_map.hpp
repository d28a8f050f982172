// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map out of its file, checked and turned to the conventions used inside, before a set gives its features their
// indices.

#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/local_map.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
struct NamedLocalMap {
  std::filesystem::path path;
  std::int64_t number = 0;
  std::vector<FeatureId> features;  ///< As in `map.feature_estimates`.
  /// False where the end pose is the start pose, exactly: zero motion of zero covariance. Then `map` is over the features only.
  bool moves = true;
  LocalMap<Dim> map;  ///< All but its indices.
};

/// 2 or 3, by the number of rows that the end pose takes.
Expected<int> dimension(const LocalMapFile& file);

/// Checks that the state is an end pose and features, each once, and that the Gaussian is finite, symmetric and, a covariance,
/// positive definite or, an information matrix, positive semidefinite (see InformationCheck). Errors name the file, and the row
/// of the state.
template <int Dim>
Expected<NamedLocalMap<Dim>> named_local_map(LocalMapFile&& file, InformationCheck& check);

}  // namespace mapjoin
