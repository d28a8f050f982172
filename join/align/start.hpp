// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a join of all maps at once may start from (the initial values of the paper's Table I).

#include <cstdint>
#include <mapjoin/join/align/piece.hpp>
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

/// Every feature of the piece at zero, and every pose but the first, which holds the map.
template <int Dim>
void set_to_zero(Piece<Dim>& piece);

/// Random values within the piece's own, the composed start; its first pose, which holds the map, stays. The same seed gives
/// the same values on every machine.
template <int Dim>
void set_to_random(std::uint64_t seed, Piece<Dim>& piece);

/// The values of `state`, which is over the whole network.
template <int Dim>
void set_to_values(const State<Dim>& state, Piece<Dim>& piece);

/// From the composed start to the one asked for; `values` are for Start::kFile, of the whole network.
template <int Dim>
void set_start(Start start, std::uint64_t seed, const State<Dim>* values, Piece<Dim>& piece);

}  // namespace mapjoin
