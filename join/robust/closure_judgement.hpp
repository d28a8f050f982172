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
  kOpen,     ///< It is not in the map, and within the narrow gate of what that says; or there is no map yet.
  kKept,     ///< It counts in the map.
  kDropped,  ///< It is not in the map, and beyond the narrow gate.
};

/// What a map says of each closure of a log.
template <int Dim>
struct ClosureJudgement {
  std::vector<Standing> standing;
  std::vector<double> chi2;  ///< From its prediction by all others that count; a lower bound beyond the widest gate.
  std::vector<UncertainPose<Dim>> mismatches;  ///< Measured less predicted, of those that are not kept.
  Values<Dim> values;                          ///< Of the map.
};

/// Tests closures of `log` against a map of the chosen ones (ascending): these exactly, the others by its predictions. Some are
/// missing once a stop is requested.
template <int Dim>
ClosureJudgement<Dim> judge(const Log<Dim>& log, const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join,
                            const Gates& gates, const std::stop_token& stop);

/// Whether each closure is to be in the next map: it is kept, or within the narrow gate, or within the widest gate and right
/// more likely than wrong. A contradicted closure (one beyond the widest gate) counts against it where what that measured would
/// pass the widest gate in its place. For it count all between the two gates that are kept, or that nothing counts against;
/// where there are none, nothing may count against it.
template <int Dim>
std::vector<bool> fits_beyond_chance(const ClosureJudgement<Dim>& judgement, std::span<const PoseFactor<Dim>> closures,
                                     const Gates& gates);

}  // namespace mapjoin
