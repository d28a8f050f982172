// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which updates that wait could enter the estimate of an incremental join together.

#include <cstddef>
#include <deque>
#include <mapjoin/join/incremental/named_estimate.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <vector>

namespace mapjoin {

/// Of the updates with the numbers `waiting`, those that names tie to the estimate, if only by way of each other, in one group;
/// where the estimate is empty, a group of each that names tie to each other, in the order of their first ones. Numbers of a
/// group keep their order.
template <int Dim>
std::vector<std::vector<std::size_t>> tied_updates(const std::deque<SubmapUpdate<Dim>>& updates,
                                                   const std::vector<std::size_t>& waiting, const NamedEstimate<Dim>& estimate);

}  // namespace mapjoin
