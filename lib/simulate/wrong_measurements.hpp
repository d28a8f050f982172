// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs with known wrong measurements planted among their own: closures between places that only look alike, and observations
// under the name of another feature.

#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// The poses that wrong closures tie together: the policies of the data set generator of Sünderhauf and Protzel, "Switchable
/// constraints for robust pose graph SLAM" (IROS 2012). A group is a run of 20 closures, from successive poses to successive
/// poses, that all have the same relative pose, so that they agree with each other.
enum class ClosurePolicy : std::uint8_t {
  kRandom,        ///< Any two poses.
  kLocal,         ///< Two poses at most 20 steps apart.
  kRandomGroups,  ///< Groups whose first closure ties any two poses.
  kLocalGroups,   ///< Groups whose first closure ties two poses at most 20 steps apart.
};
constexpr auto enum_names(ClosurePolicy) {
  return std::to_array<EnumName<ClosurePolicy>>({{ClosurePolicy::kRandom, "random"},
                                                 {ClosurePolicy::kLocal, "local"},
                                                 {ClosurePolicy::kRandomGroups, "random-groups"},
                                                 {ClosurePolicy::kLocalGroups, "local-groups"}});
}

/// A log with wrong measurements.
template <int Dim>
struct Planted {
  Log<Dim> log;
  std::vector<bool> is_wrong;  ///< By closure of the log or, if identities were changed, by observation.
};

/// Adds `count` wrong closures after the log's own. Their relative poses are near the identity, with normal deviations of 0.3 m
/// along and 10 degrees about every axis; their information is that of any of the log's closures (of its odometry if it has
/// none). Ends are at least two steps apart, and may be tied more than once. The same seed gives the same closures; a smaller
/// `count` gives the first of them. Throws std::invalid_argument if the log has too few poses for a group, or no edge.
template <int Dim>
Planted<Dim> plant_wrong_closures(const Log<Dim>& log, ClosurePolicy policy, std::size_t count, std::uint64_t seed);

/// Gives each observation, with probability `share`, the name of any other feature. Throws std::invalid_argument if the log has
/// fewer than two features.
template <int Dim>
Planted<Dim> plant_wrong_identities(const Log<Dim>& log, double share, std::uint64_t seed);

/// A set of local maps, some of whose features are under wrong names.
template <int Dim>
struct PlantedSet {
  SubmapSet<Dim> set;
  std::vector<std::vector<bool>> is_wrong;  ///< By map, then by its feature.
};

/// Gives each feature of a local map, with probability `share`, the name of any other feature of the set. A feature keeps its
/// own name if the map has that other feature already, or if no map would have its own any more. Throws std::invalid_argument
/// if the set has fewer than two features.
template <int Dim>
PlantedSet<Dim> plant_wrong_identities(const SubmapSet<Dim>& set, double share, std::uint64_t seed);

}  // namespace mapjoin
