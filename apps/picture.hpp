// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Pictures of maps, as SVG: equal axes, trajectories and features of one map or of several on top of each other.

#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The poses composed from odometry alone, each session from where the map has its first pose.
template <int Dim>
std::vector<Pose<Dim>> dead_reckoning(const Log<Dim>& log, const GlobalMap<Dim>& map);

enum class Mark { kDot, kRing };

/// What is drawn in one colour. It points to what must outlive it.
template <int Dim>
struct Layer {
  std::string name;    ///< In the legend.
  std::string colour;  ///< As SVG has it.
  const std::vector<Pose<Dim>>* poses = nullptr;
  const std::vector<Point<Dim>>* features = nullptr;
  double width = 1.4;  ///< Of the trajectory, in pixels.
  Mark mark = Mark::kDot;
  bool is_framed = true;  ///< The picture holds all of it; else what lies beyond the others is cut off.
};

/// The layers seen from above (x to the right, y up, in metres), the first at the bottom and last in the legend, with a scale.
/// Trajectories are thinned, and of very many features some are left out, so that the size of the picture is bounded. Its
/// longer side has `pixels`.
template <int Dim>
std::string picture(const std::vector<Layer<Dim>>& layers, const std::vector<Session>& sessions, double pixels = 1000.0);

/// Draws a map; `odometry` may be empty. kCannotWrite.
template <int Dim>
Expected<void> write_picture(const GlobalMap<Dim>& map, const std::vector<Pose<Dim>>& odometry,
                             const std::vector<Session>& sessions, const std::filesystem::path& path);

}  // namespace mapjoin::apps
