// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Several logs as one: each a session with its own names of poses, tied by features of the same name and by edges that name
// poses of another log.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

struct MergeOptions {
  bool keep_copies = false;   ///< An edge to another log's pose that stands in both logs, number by number, counts twice.
  bool own_features = false;  ///< Features of the same name in different logs are different ones.
};

/// The first session of each of several logs or sets of maps, behind all those before; bad input where they are too many.
template <typename Part>
Expected<std::vector<std::uint32_t>> first_sessions(const std::vector<Part>& parts) {
  std::vector<std::uint32_t> first;
  std::uint64_t next = 0;
  for (const Part& part : parts) {
    first.push_back(static_cast<std::uint32_t>(next));
    std::uint64_t last = 0;
    for (const PoseId& id : part.poses) last = std::max<std::uint64_t>(last, id.session);
    next += last + 1;
    if (next > std::uint64_t{1} << 32)
      return bad_input(part.source + ": with the sessions of the inputs before, its own go beyond 2^32");
  }
  return first;
}

/// The least power of ten above `largest`, so many times which fits into an id; else kUsage.
Expected<std::uint64_t> step_apart(std::uint64_t largest, std::size_t parts);

/// Gives the features of every log or set of maps numbers that those of no other have: from n times a power of ten on.
template <typename Part>
Expected<void> number_features_apart(std::vector<Part>& parts) {
  std::uint64_t largest = 0;
  for (const Part& part : parts) {
    for (const FeatureId& id : part.features) largest = std::max(largest, id.key);
  }
  return step_apart(largest, parts.size()).map([&](std::uint64_t step) {
    for (std::size_t k = 0; k < parts.size(); ++k) {
      for (FeatureId& id : parts[k].features) id.key += k * step;
    }
  });
}

/// The logs, at least one, as one log. The sessions of a log, most have one, follow those of the logs before it. Each log is in
/// a frame of its own: the first that fixes poses holds the map, and what later ones fix is left out and counted, as copies
/// are. Own features of log n are numbered from n times a power of ten on. Bad input: an edge to a pose that no log declares,
/// or several; kUsage: ids of own features that do not fit into 64 bits.
template <int Dim>
Expected<Log<Dim>> merged(std::vector<Log<Dim>> logs, const MergeOptions& options = {});

}  // namespace mapjoin
