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

/// A local map and how it was found.
template <int Dim>
struct BuiltMap {
  /// Nothing where the segment's own observations do not determine all its poses and features, or its chi2 is not finite: it
  /// then stays raw.
  std::optional<LocalMap<Dim>> map;
  int iterations = 0;
};

/// The local map of one segment (paper's VI.A), from odometry and first observations.
template <int Dim>
BuiltMap<Dim> build_local_map(const SegmentView<Dim>& view, const MinimiseOptions& solver);

template <int Dim>
struct LocalMaps {
  std::vector<LocalMap<Dim>> maps;  ///< One per segment that is a map, in their order.
  std::int64_t iterations = 0;      ///< Of all maps together.
};

/// The local maps of a log; segments whose observations leave something free to move are turned into raw ones in `split`. In
/// parallel, with the same result for any number of threads. kInterrupted where `stop` was requested. A solver whose options do
/// not validate is std::invalid_argument.
template <int Dim>
Expected<LocalMaps<Dim>> build_local_maps(const Log<Dim>& log, Split& split, const BuildOptions& options,
                                          const std::stop_token& stop = {});

/// Bad input unless the segments cover every session from its first pose to its last, each beginning where the one before
/// ends, and the maps are one per segment that is a map, in order, over the poses and features of its segment. `split` as
/// split_along made it.
template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps);

}  // namespace mapjoin
