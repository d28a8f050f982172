// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A set of local maps taken apart into a log, so that searches in logs can judge each observation on its own.

#include <cstddef>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// A log made from a set of maps: the marginal of each feature of a map and of each step between its poses, and the
/// observations that stand on their own in the set.
template <int Dim>
struct TakenApart {
  Log<Dim> log;
  /// The place of an observation of the log in the set: among the features of a map or, if `map` is the number of maps, among
  /// the observations that stand on their own.
  struct Origin {
    std::size_t map = 0;
    std::size_t place = 0;
    auto operator<=>(const Origin&) const = default;
  };
  std::vector<Origin> origins;  ///< By feature factor of the log.
};

/// Takes a set apart. Poses and features keep their indices. Pose factors of the set stay as they are, those of one kind (see
/// Log) in their order.
template <int Dim>
TakenApart<Dim> taken_apart(const SubmapSet<Dim>& set);

}  // namespace mapjoin
