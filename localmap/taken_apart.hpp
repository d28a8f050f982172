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
  std::vector<std::size_t> maps;  ///< Of each observation of the log; the number of maps where it stands on its own.
};

/// Poses and features keep their indices. Pose factors of the set stay as they are, those of one kind (see Log) in their order.
template <int Dim>
TakenApart<Dim> taken_apart(const SubmapSet<Dim>& set);

}  // namespace mapjoin
