// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Extra files that options ask for: in the folder of a run, or beside a map of one file.

#include <apps/commands/options.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// An extra file that an option asks for, in the folder of a run or beside a map of one file.
enum class Extra : std::uint8_t { kCovariances, kRelations, kAssociations, kRejected, kInliers, kGeographic, kGeoJson };
struct ExtraFile {
  Extra extra;
  const char* option;
  const char* in_folder;
  const char* beside;  ///< Replaces the extension of the map; null: only in a folder.
};
/// The extra files that the options ask for, without those of covariances if the map has none.
std::vector<ExtraFile> extra_files(const Options& options, bool has_covariances = true);
/// Those of them that lie beside a map of one file, which is no stream (is_stream()).
std::vector<ExtraFile> files_beside(const Options& options, bool has_covariances = true);
/// The name of an extra file in the folder of a run.
const char* name_in_folder(Extra extra);
/// The path of an extra file beside a map of one file: `map.covariances.json` beside `map.g2o`.
std::filesystem::path extra_file(Extra extra, const std::filesystem::path& map);
/// True if the map at this path has such an extra file: in the folder of its run, whether the path is that or a file of it, or
/// beside the map of one file, or the store.
bool has_extra_file(Extra extra, const std::filesystem::path& map);
/// True if a file of this name in the folder of a run is an extra file.
bool is_extra_of_run(const std::string& name);
/// Files that are named like extra files beside a map of one file, but are not among `written`: an earlier call left them.
std::vector<std::filesystem::path> extra_files_left(const std::filesystem::path& map, const std::vector<std::string>& written);

}  // namespace mapjoin::apps
