// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A set of local maps as a log: what a search in logs is to judge, each thing on its own.

#include <cstddef>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <vector>

namespace mapjoin {

/// A log of what each map of a set says of each of its features alone and of its poses, one after the other, and of what
/// stands on its own in the set.
template <int Dim>
struct TakenApart {
  Log<Dim> log;
  /// Where an observation of the log is in the set: among the features of a map or, where `map` is the number of maps, among
  /// the observations that stand on their own.
  struct Origin {
    std::size_t map = 0;
    std::size_t place = 0;
    auto operator<=>(const Origin&) const = default;
  };
  std::vector<Origin> origins;  ///< Of each observation.
};

/// Poses and features keep their indices. Pose factors of the set stay as they are, those of one kind (see Log) in their order.
template <int Dim>
TakenApart<Dim> taken_apart(const SubmapSet<Dim>& set);

}  // namespace mapjoin
