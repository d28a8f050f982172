// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a map of some closures of a log says of all of them.

#include <cstdint>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// What is known of a closure.
enum class Standing : std::uint8_t {
  kOpen,     ///< The map, which it has no part in, agrees with it.
  kKept,     ///< It counts in the map.
  kDropped,  ///< It is beyond the narrow gate.
};

/// What a map says of each closure of a log.
template <int Dim>
struct ClosureJudgement {
  std::vector<Standing> standing;
  std::vector<double> chi2;  ///< From its prediction by all others that count; beyond the widest gate, at least.
  std::vector<UncertainPose<Dim>> mismatches;  ///< Measured less predicted, of those that are not kept.
  Values<Dim> values;                          ///< Of the map.
};

/// Tests closures of `log` against a map of the chosen ones (ascending): these exactly, the others by its predictions. Some are
/// missing once a stop is requested.
template <int Dim>
ClosureJudgement<Dim> judge(const Log<Dim>& log, const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join,
                            const Gates& gates, const std::stop_token& stop);

/// Whether each closure is kept, is within the narrow gate or, unless by chance, within the widest one: where what a closure
/// beyond that one measured would pass it, too, a wrong one may be here by chance.
template <int Dim>
std::vector<bool> fits_beyond_chance(const ClosureJudgement<Dim>& judgement, std::span<const PoseFactor<Dim>> closures,
                                     const Gates& gates);

}  // namespace mapjoin
