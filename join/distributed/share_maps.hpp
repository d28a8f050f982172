// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The local maps of one rank.

#include <mapjoin/distributed/log_share.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/split.hpp>
#include <optional>
#include <vector>

namespace mapjoin::distributed {

/// By the indices of the share's log.
template <int Dim>
struct ShareMaps {
  Split split;  ///< What did not determine a map is raw.
  std::vector<LocalMap<Dim>> maps;
  std::int64_t iterations = 0;  ///< Of those that were built now.
  bool is_resumed = false;      ///< Some were in a store before.
  bool was_damaged = false;     ///< A store that was not finished was damaged.
};

template <int Dim>
Expected<ShareMaps<Dim>> built_maps(const LogShare<Dim>& share, const RunOptions& options);

/// Takes the maps of those of its segments that are maps, in their order, by the indices of all names; what is nothing did not
/// determine a map. Bad input where they are not of this share.
template <int Dim>
Expected<void> take_maps(const LogShare<Dim>& share, std::vector<std::optional<LocalMap<Dim>>> maps, ShareMaps<Dim>& into);

}  // namespace mapjoin::distributed
