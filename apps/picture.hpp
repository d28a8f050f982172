// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A picture of a map, as SVG: equal axes, trajectory, features, and the trajectory of odometry alone beside it.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin::apps {

/// The poses composed from odometry alone, each session from where the map has its first pose.
template <int Dim>
std::vector<Pose<Dim>> dead_reckoning(const Log<Dim>& log, const GlobalMap<Dim>& map);

/// Draws the map seen from above (x to the right, y up, in metres); `odometry` may be empty. kCannotWrite.
template <int Dim>
Expected<void> write_picture(const GlobalMap<Dim>& map, const std::vector<Pose<Dim>>& odometry,
                             const std::vector<Session>& sessions, const std::filesystem::path& path);

}  // namespace mapjoin::apps
