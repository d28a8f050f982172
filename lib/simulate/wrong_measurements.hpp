// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs with wrong measurements among their own, which are known: closures between places that only look alike, and
// observations under the name of another feature.

#include <cstdint>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// Which poses wrong closures tie together: the policies of Sünderhauf and Protzel, "Switchable constraints for robust pose
/// graph SLAM" (IROS 2012), as their data set generator has them. A group is a run of 20 closures, from successive poses to
/// successive poses, that all have the same relative pose, so that they agree with each other.
enum class ClosurePolicy : std::uint8_t {
  kRandom,        ///< Any two.
  kLocal,         ///< Two that are at most 20 steps apart.
  kRandomGroups,  ///< Groups, whose first closure ties any two.
  kLocalGroups,   ///< Groups, whose first closure ties two that are at most 20 steps apart.
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
  std::vector<bool> is_wrong;  ///< Of each closure of the log or, where identities were changed, of each observation.
};

/// Adds `count` wrong closures after the log's own. Their relative poses are near the identity, with normal deviations of 0.3 m
/// along and 10 degrees about every axis; their information is that of any of the log's closures (of its odometry where it has
/// none). Ends are at least two steps apart, and may be tied more than once. The same seed gives the same closures, fewer of
/// them where fewer are asked for. Throws std::invalid_argument where the log has too few poses for a group, or no edge.
template <int Dim>
Planted<Dim> plant_wrong_closures(const Log<Dim>& log, ClosurePolicy policy, std::size_t count, std::uint64_t seed);

/// Gives each observation, with probability `share`, the name of any other feature. Throws std::invalid_argument where the log
/// has fewer than two features.
template <int Dim>
Planted<Dim> plant_wrong_identities(const Log<Dim>& log, double share, std::uint64_t seed);

/// A set of local maps, some of whose features are under wrong names.
template <int Dim>
struct PlantedSet {
  SubmapSet<Dim> set;
  std::vector<std::vector<bool>> is_wrong;  ///< Of each map, of each of its features.
};

/// Gives each feature of a local map, with probability `share`, the name of any other feature of the set. It keeps its own
/// where the map has that other feature already, or where no map would have its own any more. Throws as for a log.
template <int Dim>
PlantedSet<Dim> plant_wrong_identities(const SubmapSet<Dim>& set, double share, std::uint64_t seed);

}  // namespace mapjoin
