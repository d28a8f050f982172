// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What options ask for beside a map: in the folder of a run, or beside a map that is one file.

#include <apps/commands/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// What an option asks for beside the map: a file in the folder of a run, or beside a map that is one file.
enum class Extra : std::uint8_t { kCovariances, kRelations, kAssociations, kRejected, kInliers, kGeographic, kGeoJson };
struct ExtraFile {
  Extra extra;
  const char* option;
  const char* in_folder;
  const char* beside;  ///< For the extension of the map; null: only in a folder.
};
/// All that the options ask for; a map may have no covariances though they are asked for.
std::vector<ExtraFile> extra_files(const Options& options, bool has_covariances = true);
/// Beside a map that is one file: `map.covariances.json` beside `map.g2o`.
std::filesystem::path extra_file(Extra extra, const std::filesystem::path& map);
/// Whether a file of this name in the folder of a run is one of these.
bool is_extra_of_run(const std::string& name);
/// What lies beside a map that is one file under the names of such files and is none of `written`: it is of an earlier map.
std::vector<std::filesystem::path> extra_files_left(const std::filesystem::path& map, const std::vector<std::string>& written);

}  // namespace mapjoin::apps
