// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local maps of several robots or days, or the parts of one build, as one set to be joined.

#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <vector>

namespace mapjoin {

/// The maps of several stores, or of several sets of others' maps, as those of one: each a session (see merged()), tied by the
/// features that they share; but stores of one log are parts of its maps, and what no part has is joined as it was observed. A
/// store knows its log, and its maps have every feature that was seen, so that the join is that of one log. Portions of a log,
/// which are all to be there, are put together. Bad input: stores beside sets, what open_maps() refuses, other dimensions, and
/// parts that are cut in different ways.
Expected<AnyMaps> open_several_maps(const std::vector<std::filesystem::path>& paths, const ReadOptions& options = {},
                                    const MergeOptions& merging = {});

}  // namespace mapjoin
