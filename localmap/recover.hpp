// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Recovery after joining of interior poses, which were eliminated when their local map was built.

#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The values of a segment's poses and features, taken from the state of the whole log.
template <int Dim>
Values<Dim> values_of(const SegmentView<Dim>& view, const Values<Dim>& state);

/// Re-solves the segment of every local map for its interior poses and submap-local features, with kept poses and shared
/// features held at their joined values; `state` is over the poses and features of the log. In parallel, with the same result
/// for any number of threads. Returns the number of segments whose solve did not converge; their interior is the best found.
template <int Dim>
std::size_t recover_interiors(const Log<Dim>& log, const Split& split, const Table<FeatureIndex, bool>& is_local,
                              const MinimiseOptions& solver, Values<Dim>& state, const std::stop_token& stop = {});

}  // namespace mapjoin
