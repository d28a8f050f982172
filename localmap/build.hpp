// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Building local maps: least squares over each segment in the frame of its start pose, then its interior eliminated.

#include <functional>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

struct BuildOptions {
  MinimiseOptions solver;
  /// Called after every map with the number done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;
};

/// A local map and the effort of finding it.
template <int Dim>
struct BuiltMap {
  /// nullopt if the segment's own observations do not determine all its poses and features, or its solve makes no progress
  /// (chi2 is not finite, say): the segment then stays raw. Nor is there one if a stop ended the solve.
  std::optional<LocalMap<Dim>> map;
  int iterations = 0;
};

/// The local map of one segment (paper's VI.A), solved from a start by odometry and first observations.
template <int Dim>
BuiltMap<Dim> build_local_map(const SegmentView<Dim>& view, const MinimiseOptions& solver, const std::stop_token& stop = {});

template <int Dim>
struct LocalMaps {
  std::vector<LocalMap<Dim>> maps;  ///< One per segment that is a map, in their order.
  std::int64_t iterations = 0;      ///< Sum over all maps.
};

/// The local maps of a log; segments whose observations leave something free to move are turned into raw ones in `split`. In
/// parallel, with the same result for any number of threads. kInterrupted on stop. Throws std::invalid_argument if the options
/// of the solver do not validate; bad input if check_split() finds a fault.
template <int Dim>
Expected<LocalMaps<Dim>> build_local_maps(const Log<Dim>& log, Split& split, const BuildOptions& options,
                                          const std::stop_token& stop = {});

/// Checks that local maps are those of a split. kBadInput if check_split() finds a fault, and unless the maps are one per
/// segment that is a map, in order, over the poses and features of that segment.
template <int Dim>
Expected<void> check_maps_of_split(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps);

/// Checks the local maps of a whole log. kBadInput if check_maps_of_split() finds a fault, and unless the segments end with the
/// last pose and the numbers of the maps are valid.
template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps);

}  // namespace mapjoin
