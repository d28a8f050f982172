// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files that a command writes: how a map's are called, that they can be written, and that none is written over another.

#include <apps/commands/options.hpp>
#include <apps/extra_files.hpp>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

/// Files by what the command takes them for, such as "--output".
using NamedFiles = std::vector<std::pair<std::string, std::filesystem::path>>;

/// The inputs, the first under the name of its argument, and the truth.
NamedFiles inputs_of(const Options& options, const std::string& argument);
/// The report, unless it goes to standard output.
NamedFiles report_of(const Options& options);
/// The output and the report.
NamedFiles outputs_of(const Options& options);
/// As outputs_of(), with the associations beside a store.
NamedFiles outputs_of_store(const Options& options);
/// As outputs_of(), with what is written beside a map that is one file: features of a CSV map, covariances, relations, what was
/// rejected, associations.
NamedFiles outputs_of_map(const Options& options);
/// As outputs_of(), with the files of these names in the folder that the output is, where there is one.
NamedFiles outputs_of_folder(const Options& options, const std::vector<std::string>& names);

/// In words, any output that is one file with an input or with another output, or would be: by links and by names, where one is
/// yet to come; of an input that is a folder, with what is read there. And any of them that is what an output is until it is
/// done. Empty paths and what is there but not a regular file, such as /dev/null, are like no other.
std::vector<std::string> output_conflicts(const NamedFiles& inputs, const NamedFiles& outputs);
/// In words, any file that is in the place which an output has until it is done, below it, or its journal.
std::vector<std::string> unfinished_conflicts(const NamedFiles& files, const std::string& output,
                                              const std::filesystem::path& unfinished);
/// In words, any of these files that a run may replace or remove in its folder or, where that is of several `parts`, in one of
/// a part; there also what is in the place of a file until it is done.
std::vector<std::string> conflicts_with_run(const NamedFiles& files, const std::filesystem::path& folder, bool parts);

/// Fails with kCannotWrite where a file cannot be made: better known before the work than after it. Devices and pipes are left
/// alone, and so are empty paths.
void check_writable(const NamedFiles& files);

/// The extension of a path in lower case: .G2O is .g2o.
std::string extension_of(const std::filesystem::path& path);

/// Whether a path names the file of a map, by its extension: .g2o, .tum, .csv or .mat, and there is no folder of that name.
bool names_map_file(const std::filesystem::path& path);

/// Whether the extension of a path says what is to be written there: not where there is none, nor of a folder, a device or a
/// pipe that is there.
bool goes_by_extension(const std::filesystem::path& path);

/// In words, an extension that should name the format of a map, and is none of these. A folder has none, ends in / or is there
/// already.
std::vector<std::string> check_extension(const std::filesystem::path& path);

/// The name of the map in the folder of a run.
inline constexpr const char* kMapOfRun = "map.g2o";
inline constexpr const char* kReportOfRun = "report.json";
/// What every run writes into its folder beside its report; it may write more.
inline constexpr std::array kFilesOfRun = {kMapOfRun, "trajectory.tum", "poses.csv", "features.csv", "map.svg"};
/// Whether a run, with whatever options, may write a file of this name into its folder.
bool is_file_of_run(const std::string& name);
/// The trajectory of one session, of several, in the folder of a run.
std::string trajectory_of(std::uint32_t session);
/// The folder of a part, counted from 0, in that of a run with `--parts all`.
std::string folder_of_part(std::size_t part);
/// The map in the folder of a run, else the path as it is.
std::filesystem::path map_of_run(const std::filesystem::path& path);

/// The files of a map: of a `.csv` its features beside it, in `.features.csv`.
std::vector<std::filesystem::path> map_files(const std::filesystem::path& path);

/// `.tum`: the trajectory, without features. `.csv`: the poses, and the features beside them. `.mat`: matrices. Else g2o, with
/// the edges of `log` where it is given. kCannotWrite; kUsage of what MAT cannot say.
template <int Dim>
Expected<void> write_map_file(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path);

}  // namespace mapjoin::apps
