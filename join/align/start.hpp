// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The joined map of a whole submap graph, and its initial values (those of the paper's Table I).

#include <cstdint>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/model/enum_names.hpp>

namespace mapjoin {

enum class Start : std::uint8_t {
  kComposed,  ///< Odometry and first observations, or local maps, one after the other.
  kZero,      ///< Every position and rotation zero.
  kRandom,    ///< Positions uniform over the bounding box of the composed start, rotations uniform.
  kFile,      ///< The initial values in the log.
};

constexpr auto enum_names(Start) {
  return std::to_array<EnumName<Start>>(
      {{Start::kComposed, "composed"}, {Start::kZero, "zero"}, {Start::kRandom, "random"}, {Start::kFile, "file"}});
}

/// All poses, features, maps and observations of a submap graph, in its order, as one partial map; its state is zero.
template <int Dim>
PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>& graph);

/// The state of `joined_map` from the partial maps of the join, several if only the World ties them together: the composed
/// start of the last join. A partial map that the World does not tie has its first pose at `origin`.
template <int Dim>
Values<Dim> composed_state(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Pose<Dim>& origin,
                           JoinedPartialMaps<Dim> joined);

/// The values of the partial map's poses and features, by place, in `state`, which is over the whole submap graph.
template <int Dim>
Values<Dim> restricted(const Values<Dim>& state, const PartialMap<Dim>& partial);

/// Sets every feature of the partial map to zero, and every pose but the first, which holds the map.
template <int Dim>
void set_to_zero(PartialMap<Dim>& partial);

/// Sets random rotations, and random positions within the bounding box of the present ones, the composed start; the first pose,
/// which holds the map, stays. The same seed gives the same values on every machine.
template <int Dim>
void set_to_random(std::uint64_t seed, PartialMap<Dim>& partial);

/// Replaces the composed start by `start`; `values`, over the whole submap graph, are for Start::kFile.
template <int Dim>
void set_start(Start start, std::uint64_t seed, const Values<Dim>* values, PartialMap<Dim>& partial);

}  // namespace mapjoin
