// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The folder of a run as a log: its map, under the names of the log that it was made of.

#include <filesystem>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// The names of the map in the folder of a run, and of the tables that tell the names in it.
inline constexpr const char* kMapOfRun = "map.g2o";
inline constexpr const char* kPosesOfRun = "poses.csv";
inline constexpr const char* kFeaturesOfRun = "features.csv";

/// True if the folder has a `map.g2o`, as folders of runs do, and no local maps.
bool is_run_folder(const std::filesystem::path& path);

/// The log in the `map.g2o` of the folder of a run, with the names, the order and the time stamps that `poses.csv` and
/// `features.csv` beside it tell; without both as it is. Bad input, too, if one is missing, or if they are of another map.
Expected<AnyLog> read_run_folder(const std::filesystem::path& folder, const ReadOptions& options);

/// The log of a map under the names that `told` has, with poses in its order. A g2o file has one numbering, and so names
/// features and the poses of further sessions anew; other files keep the names. Bad input, which names `file`, where `told` is
/// from: it has other poses or features, or has them elsewhere. Features do not count if the log has none.
template <int Dim>
Expected<Log<Dim>> with_names(const GlobalMap<Dim>& told, Log<Dim> log, const std::filesystem::path& file);

/// The error of a file that is of another map than the one beside it.
tl::unexpected<Error> not_of_map_beside(const std::filesystem::path& file);

}  // namespace mapjoin
