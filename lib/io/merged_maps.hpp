// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local maps of several robots or days as one set to be joined, tied by the features that they share.

#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <vector>

namespace mapjoin {

/// The maps of several stores, or of several sets of others' maps, as those of one: each a session (see merged()). A store
/// knows its log: a map inside which a feature was marginalised that another store sees, too, gives way to its observations, so
/// that the join is that of one log. Bad input: stores beside sets, what open_maps() refuses, and other dimensions.
Expected<AnyMaps> open_several_maps(const std::vector<std::filesystem::path>& paths, const ReadOptions& options = {},
                                    const MergeOptions& merging = {});

}  // namespace mapjoin
