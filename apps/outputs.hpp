// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The files that a command writes: the names of those of a map, and checks that they can be written and that none overwrites
// another.

#include <apps/commands/options.hpp>
#include <apps/extra_files.hpp>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mapjoin/io/run_folder.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

/// Files, each with the option or argument that names it, such as "--output".
using NamedFiles = std::vector<std::pair<std::string, std::filesystem::path>>;

/// The inputs, the first under the name of its argument, and the files of --truth, --stamps and --gps.
NamedFiles inputs_of(const Options& options, const std::string& argument);
/// The report.
NamedFiles report_of(const Options& options);
/// The output and the report.
NamedFiles outputs_of(const Options& options);
/// The output and the report, with the associations beside a store.
NamedFiles outputs_of_store(const Options& options);
/// The output and the report, with the files beside a map of one file: features of a CSV map, and extra files.
NamedFiles outputs_of_map(const Options& options);
/// The output and the report, with the files of these names in the output folder, if there is one.
NamedFiles outputs_of_folder(const Options& options, const std::vector<std::string>& names);

/// The inputs, with each folder replaced by the files that are read there.
NamedFiles files_read(const NamedFiles& inputs);

/// Violations, in words: an output that is, or would become, one file with an input, with a file that is read in an input
/// folder, or with another output, by links or by name; any file in the place of an unfinished output; and several outputs on
/// standard output. Empty paths, and existing ones of no regular file, such as /dev/null, are one file with no other.
std::vector<std::string> output_conflicts(const NamedFiles& inputs, NamedFiles outputs);
/// Violations, in words: a file at the place of an unfinished output, below it, or its journal.
std::vector<std::string> unfinished_conflicts(const NamedFiles& files, const std::string& output,
                                              const std::filesystem::path& unfinished);
/// Violations, in words: a file in the place of a store, named `output`, until it is done.
std::vector<std::string> unfinished_store_conflicts(const NamedFiles& files, const std::string& output,
                                                    const std::filesystem::path& store);
/// Violations, in words: a file that a run may replace or remove in its folder or, if that has several `parts`, in the folder
/// of a part; there also one in the place of an unfinished file. Of several files of one name and folder the first is told.
std::vector<std::string> conflicts_with_run(const NamedFiles& files, const std::filesystem::path& folder, bool parts);

/// Fails with kCannotWrite if a file cannot be made, which is better known before the work than after it. Devices, pipes and
/// empty paths are skipped.
void check_writable(const NamedFiles& files);

/// The extension of a path in lower case: .G2O is .g2o.
std::string extension_of(const std::filesystem::path& path);

/// True if a path names a map of one file: its extension is .g2o, .tum, .csv or .mat, and it is not an existing folder; or it
/// is a device, a pipe or standard output.
bool names_map_file(const std::filesystem::path& path);

/// True if a map of one file is written as g2o there: where the extension is of no other format.
bool is_written_as_g2o(const std::filesystem::path& path);

/// True if the extension of a path says what is to be written there: it has one, and is no existing folder, device or pipe.
bool goes_by_extension(const std::filesystem::path& path);

/// A violation, in words: an extension that is none of those of a map. A folder, which some commands take, has no extension,
/// ends in /, or exists already.
std::vector<std::string> check_extension(const std::filesystem::path& path, bool takes_folder = false);
/// Like check_extension(), for a command that takes no new name without an extension either: `mapjoin run` makes a folder of
/// it.
std::vector<std::string> demand_extension(const std::filesystem::path& path);

inline constexpr const char* kReportOfRun = "report.json";
inline constexpr const char* kTrajectoryOfRun = "trajectory.tum";
inline constexpr const char* kPictureOfRun = "map.svg";
/// The files that every run writes into its folder beside its report; options may add others.
inline constexpr std::array kFilesOfRun = {kMapOfRun, kTrajectoryOfRun, kPosesOfRun, kFeaturesOfRun, kPictureOfRun};
/// True if a run may write a file of this name into its folder, whatever its options.
bool is_file_of_run(const std::string& name);
/// The name of the trajectory of one of several sessions, in the folder of a run.
std::string trajectory_of(std::uint32_t session);
/// The name of the folder of a part, counted from 0, in that of a run with `--parts all`.
std::string folder_of_part(std::size_t part);
/// The paths in the folder of a run that are named like folders of parts.
std::vector<std::filesystem::path> folders_of_parts(const std::filesystem::path& folder);

/// The files that an earlier run wrote into a folder, by its report there, which lists itself among them.
std::vector<std::string> files_of_former_run(const std::filesystem::path& folder);

/// The folder of a run and those of parts in it that hold a run, except the folders `written`.
std::vector<std::filesystem::path> other_runs_in(const std::filesystem::path& folder,
                                                 const std::vector<std::filesystem::path>& written);

/// The files of a map: the path itself and, for `.csv`, that of its features beside it, in `.features.csv`.
std::vector<std::filesystem::path> map_files(const std::filesystem::path& path);

/// Writes a map in the format of its extension. `.tum`: the trajectory, without features; `.csv`: the poses, and the features
/// beside them; `.mat`: matrices; otherwise g2o, with the edges of `log` unless it is null. kCannotWrite; kUsage if MAT cannot
/// hold it.
template <int Dim>
Expected<void> write_map_file(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path);

}  // namespace mapjoin::apps
