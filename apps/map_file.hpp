// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A global map as one file, in the format that its name asks for; its covariances and relations beside it.

#include <filesystem>
#include <mapjoin/join/map_covariances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// kCannotWrite where no file can be made at `path`: better known before the work than after it. Devices and pipes are left
/// alone, and so is an empty path.
Expected<void> check_writable(const std::filesystem::path& path);

/// The extension of a path in lower case: .G2O is .g2o.
std::string extension_of(const std::filesystem::path& path);

/// Whether a path names the file of a map, by its extension: .g2o, .tum or .csv, and there is no folder of that name.
bool names_map_file(const std::filesystem::path& path);

/// In words, an extension that is none of these three, and no folder's: a folder has none, ends in / or is there already. Paths
/// that are there and neither file nor folder, such as /dev/stdout, are left alone.
std::vector<std::string> check_extension(const std::filesystem::path& path);

/// The files that write_map_file() makes for `path`, and whether they can be made, as above.
std::vector<std::filesystem::path> map_files(const std::filesystem::path& path);
Expected<void> check_map_writable(const std::filesystem::path& path);

/// `.tum`: the trajectory, without features. `.csv`: the poses, and the features beside them in `.features.csv`. Else
/// g2o, with the edges of `log` where it is given. The files written, or kCannotWrite.
template <int Dim>
Expected<std::vector<std::string>> write_map_file(const GlobalMap<Dim>& map, const Log<Dim>* log,
                                                  const std::filesystem::path& path);

/// Where the covariances of a map go that is one file: `map.covariances.json` beside `map.g2o`.
std::filesystem::path covariance_file(const std::filesystem::path& map);

/// The marginal covariances that `map` holds, of the estimate named; kCannotWrite.
template <int Dim>
Expected<void> write_covariances(const GlobalMap<Dim>& map, Estimate estimate, const std::filesystem::path& path);

/// Where the relations of a map go that is one file: `map.relations.csv` beside `map.g2o`.
std::filesystem::path relation_file(const std::filesystem::path& map);

/// One line per pose, after that of its parent, then one per feature; kCannotWrite.
template <int Dim>
Expected<void> write_relations(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals,
                               const std::filesystem::path& path);

}  // namespace mapjoin::apps
