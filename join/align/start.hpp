// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a join of all maps at once may start from (the initial values of the paper's Table I).

#include <cstdint>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/model/enum_names.hpp>

namespace mapjoin {

enum class Start : std::uint8_t {
  kComposed,  ///< Odometry and first observations, or local maps, one after the other.
  kZero,      ///< Every position and rotation zero.
  kRandom,    ///< Positions uniform over the bounding box of the composed start, rotations uniform.
  kFile,      ///< The values the log brings along.
};

constexpr auto enum_names(Start) {
  return std::to_array<EnumName<Start>>(
      {{Start::kComposed, "composed"}, {Start::kZero, "zero"}, {Start::kRandom, "random"}, {Start::kFile, "file"}});
}

/// Every feature of the partial map at zero, and every pose but the first, which holds the map.
template <int Dim>
void set_to_zero(PartialMap<Dim>& partial);

/// Random values within the partial map's own, the composed start; its first pose, which holds the map, stays. The same seed
/// gives the same values on every machine.
template <int Dim>
void set_to_random(std::uint64_t seed, PartialMap<Dim>& partial);

/// The values of `state`, which is over the whole submap graph.
template <int Dim>
void set_to_values(const Values<Dim>& state, PartialMap<Dim>& partial);

/// From the composed start to the one asked for; `values` are for Start::kFile, of the whole submap graph.
template <int Dim>
void set_start(Start start, std::uint64_t seed, const Values<Dim>* values, PartialMap<Dim>& partial);

}  // namespace mapjoin
