// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local-map sets of the original authors: localmap_1, localmap_2, ... as MAT or Linear SLAM text files in a folder or an
// archive.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <variant>

namespace mapjoin {

/// The files decide which.
using AnyMapSet = std::variant<MapSet<2>, MapSet<3>>;

/// The maps localmap_<k>.mat or localmap_<k>.txt (either with .gz) of a folder or of a .tar or .tar.gz archive, k = 1, 2, ...
/// in the order of their numbers. Map k goes from pose k-1 to pose k; those are the poses' keys. Where a map's end pose is its
/// start pose, exactly (zero motion of zero covariance), they are one pose under the name of the start, and the map observes
/// features only. In 3D the Gaussian over the file's three angles is turned to the rotation vector at the end pose of the map.
/// A missing number, a number given twice, maps of both dimensions, and what named_local_map refuses are errors.
Expected<AnyMapSet> read_local_map_set(const std::filesystem::path& folder_or_archive, const ReadOptions& options = {});

}  // namespace mapjoin
