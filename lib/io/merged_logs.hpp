// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Several logs as one: each a session with its own names of poses, tied by features of the same name and by edges that name
// poses of another log.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin {

struct MergeOptions {
  /// Counts twice what is there twice, number by number: an edge to another log's pose that stands in both logs, and a log or a
  /// set of maps that is a copy of another (see check_no_copies()).
  bool keep_copies = false;
  bool own_features = false;  ///< Keeps features of the same name in different logs apart.
};

/// The first session of each of several logs or sets of maps, behind all those before; bad input if there are too many.
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

/// The conventions of a log or set of maps, with its name for messages.
struct NamedConventions {
  std::string source;
  Conventions conventions;
};

/// The conventions of several logs or sets of maps together, at least one. Where they were read in different ones, those used
/// inside, to which all were turned. Bad input if some have the identity for weights and others do not: their chi2 together
/// would mean nothing.
Expected<Conventions> common_conventions(const std::vector<NamedConventions>& all);

/// kUsage if one of several logs or sets of maps is a copy of another: it has the same names of poses and features and the same
/// factors and maps, to the last bit, as no two noisy ones have, and so many that something is measured more than once. Values,
/// time stamps and fixed poses may differ.
template <typename Part>
Expected<void> check_no_copies(const std::vector<Part>& parts);

/// The least power of ten above `largest`; kUsage if `parts` times that does not fit into an id.
Expected<std::uint64_t> step_apart(std::uint64_t largest, std::size_t parts);

/// Gives the features of every log or set of maps numbers that no other one has: from n times a power of ten on.
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

/// The logs as one log. The sessions of a log, usually one, follow those of the logs before it. Each log is in a
/// frame of its own unless it has priors, which are all of the World: the first log with priors holds the map, otherwise the
/// first that fixes poses; fixed poses of the others are left out and counted, and so are copies of edges, time stamps unless
/// every log has them, and all initial values if several logs have one of the same feature. Own features of log n are numbered
/// from n times a power of ten on. Bad input: a fault that check_invariants() finds, an edge to a pose that no log declares, or
/// several, and weights that common_conventions() refuses; kUsage: a copy of another log (see check_no_copies()), and ids of own
/// features that do not fit into 64 bits. Throws std::invalid_argument if there is no log.
template <int Dim>
Expected<Log<Dim>> merged(std::vector<Log<Dim>> logs, const MergeOptions& options = {});

}  // namespace mapjoin
