// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What mapjoin left beside a map: its covariances and its report.

#include <filesystem>
#include <mapjoin/join/join.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <vector>

namespace mapjoin::apps {

/// Puts the covariances of `map.covariances.json` beside `map.g2o`, or of `covariances.json` in the folder of a run, into the
/// map that was read from there. Nothing where there are none; bad input where they are not of this map.
template <int Dim>
Expected<void> read_covariances_beside(const std::filesystem::path& path, GlobalMap<Dim>& map);

/// How the local maps of a run fit, by the `report.json` in its folder. Empty where there is none, where it does not say where
/// they end, and where poses are of further sessions, which have other names in a g2o file. Bad input where it is not of this
/// map.
template <int Dim>
Expected<std::vector<MapFit>> read_fits_beside(const std::filesystem::path& path, const GlobalMap<Dim>& map);

}  // namespace mapjoin::apps
