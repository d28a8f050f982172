// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tests of all closures of a log against a map of some of them.

#include <cstdint>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/join/robust/truncated_join.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The standing of a closure by the tests of a map.
enum class Standing : std::uint8_t {
  kOpen,     ///< Not in the map, but within the narrow gate of its prediction; or there is no map yet.
  kKept,     ///< Counts in the map.
  kDropped,  ///< Not in the map, and beyond the narrow gate.
};

/// The tests of each closure of a log by a map.
template <int Dim>
struct ClosureJudgement {
  std::vector<Standing> standing;
  std::vector<double> chi2;  ///< Squared distance from the prediction by all others; a lower bound beyond the widest gate.
  std::vector<UncertainPose<Dim>> mismatches;  ///< Measured less predicted, of closures that are not kept; see mismatches().
  Values<Dim> values;                          ///< The estimate of the map.
};

/// Tests the closures of `log` against a map of the chosen ones (ascending): these by the tests of `join`, the others by
/// mismatches(). Some tests are missing once a stop is requested.
template <int Dim>
ClosureJudgement<Dim> judge(const Log<Dim>& log, const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join,
                            const Gates& gates, const std::stop_token& stop);

/// Flags the closures for the next map: the kept ones, those within the narrow gate, and those within the widest gate that are
/// more likely right than wrong. A contradicted closure (one beyond the widest gate) counts against a candidate if its
/// measurement would pass the widest gate in the place of the candidate. All closures between the two gates that are kept, or
/// that nothing counts against, count for every candidate; if there are none, nothing may count against it. Of many such right
/// ones, fewer than a share of 1 - confidence may count against it where only measurements that would be as near as its own
/// count.
template <int Dim>
std::vector<bool> fits_beyond_chance(const ClosureJudgement<Dim>& judgement, std::span<const PoseFactor<Dim>> closures,
                                     const Gates& gates);

}  // namespace mapjoin
