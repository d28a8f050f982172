// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/outputs.hpp>
#include <apps/report/json.hpp>
#include <array>
#include <boost/algorithm/string/case_conv.hpp>
#include <cerrno>
#include <fstream>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/system_call.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/model/lists.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

namespace mapjoin::apps {
namespace fs = std::filesystem;
namespace {

/// The entries of a folder, sorted; empty if it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code failure;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
    entries.push_back(entry->path());
  }
  std::ranges::sort(entries);
  return entries;
}

/// True if a command reads this file of a folder that it is given: of a run, of local maps, or of UTIAS MRCLAM.
bool is_read(const fs::path& file) {
  const bool is_of_run = is_run_folder(file.parent_path()) && is_file_of_run(file.filename());
  return (is_of_run && file.filename() != kPictureOfRun) || local_map_number(file.filename()) || file.extension() == ".dat";
}

/// The input or, if it is a folder, the files read there.
NamedFiles files_of(const std::pair<std::string, fs::path>& input) {
  std::error_code ignored;
  if (!fs::is_directory(input.second, ignored)) return {input};
  NamedFiles files;
  for (const fs::path& file : entries_of(input.second)) {
    if (is_read(file)) files.emplace_back(input.first, file);
  }
  return files;
}

/// True if a path is this place, below it, or named after it, as the journal of a store is.
bool is_within(const fs::path& path, const fs::path& place) {
  const std::string there = destination(path).string();
  if (!there.starts_with(place.string())) return false;
  const std::string rest = there.substr(place.string().size());
  return rest.empty() || rest.front() == '/' || rest == "-journal";
}

/// The number in a name between its beginning and its end; nullopt for another name.
std::optional<std::uint32_t> number_between(std::string_view name, std::string_view begin, std::string_view end) {
  if (!name.starts_with(begin) || !name.ends_with(end) || name.size() < begin.size() + end.size()) return std::nullopt;
  name.remove_prefix(begin.size());
  name.remove_suffix(end.size());
  return number_in<std::uint32_t>(std::string(name));
}

/// True if a run may replace or remove a file in one of these folders, not the target of a link of that name.
bool is_of_run(const fs::path& file, const std::vector<fs::path>& folders) {
  return is_file_of_run(file.filename()) && std::ranges::find(folders, destination(file.parent_path() / ".")) != folders.end();
}

/// Violations, in words: outputs that go to standard output, where another one goes; none if all of it goes to nowhere.
std::vector<std::string> stdout_conflicts(NamedFiles outputs) {
  std::erase_if(outputs, [](const auto& output) { return !is_stdout(output.second); });
  std::vector<std::string> violations;
  for (std::size_t k = 1; k < outputs.size() && !is_stdout("/dev/null"); ++k) {
    violations.push_back(fmt::format("{} and {} cannot both go to standard output", outputs.front().first, outputs[k].first));
  }
  return violations;
}

}  // namespace

NamedFiles inputs_of(const Options& options, const std::string& argument) {
  NamedFiles files = {
      {argument, options.input}, {"--truth", options.truth}, {"--stamps", options.stamps}, {"--gps", options.gps}};
  for (const fs::path& further : options.further) files.emplace_back(kFurther, further);
  return files;
}

NamedFiles report_of(const Options& options) {
  return {{"--report", options.report}};
}

NamedFiles outputs_of(const Options& options) {
  return {{"--output", options.output}, report_of(options).front()};
}

NamedFiles outputs_of_store(const Options& options) {
  NamedFiles files = outputs_of(options);
  if (options.association) files.emplace_back("--associate", extra_file(Extra::kAssociations, options.output));
  return files;
}

NamedFiles outputs_of_map(const Options& options) {
  NamedFiles files = outputs_of(options);
  if (options.output.empty()) return files;
  const std::vector<fs::path> written = map_files(options.output);
  for (auto beside = written.begin() + 1; beside != written.end(); ++beside) files.emplace_back("--output", *beside);
  for (const ExtraFile& file : files_beside(options)) {
    files.emplace_back(file.option, extra_file(file.extra, options.output));
  }
  return files;
}

NamedFiles outputs_of_folder(const Options& options, const std::vector<std::string>& names) {
  NamedFiles files = outputs_of(options);
  for (const std::string& name : names) {
    if (!options.output.empty()) files.emplace_back("--output", options.output / name);
  }
  return files;
}

NamedFiles files_read(const NamedFiles& inputs) {
  NamedFiles read;
  for (const auto& input : inputs) append(read, files_of(input));
  return read;
}

std::vector<std::string> output_conflicts(const NamedFiles& inputs, NamedFiles outputs) {
  std::vector<std::string> violations = stdout_conflicts(outputs);
  std::erase_if(outputs, [](const auto& output) { return output.second == "-"; });
  const NamedFiles read = files_read(inputs);
  NamedFiles all = inputs;
  append(all, outputs);
  for (auto output = outputs.begin(); output != outputs.end(); ++output) {
    const auto& [name, file] = *output;
    NamedFiles others = read;
    others.insert(others.end(), outputs.begin(), output);
    for (const auto& [other, path] : others) {
      if (are_one_file(path, file)) violations.push_back(fmt::format("{} and {} are one file, {}", other, name, file.string()));
    }
    if (file.empty()) continue;
    const fs::path place = destination(file);
    append(violations, unfinished_conflicts(all, name, place.string() + kUnfinished));
    append(violations, unfinished_conflicts(all, name, place / kUnfinished));
  }
  return violations;
}

std::vector<std::string> unfinished_conflicts(const NamedFiles& files, const std::string& output, const fs::path& unfinished) {
  const fs::path place = destination(unfinished);
  std::vector<std::string> violations;
  for (const auto& [name, path] : files) {
    if (path.empty() || !(is_within(path, place) || are_one_file(path, unfinished))) continue;
    violations.push_back(
        fmt::format("{} {} is what {} is until it is done: give it another name", name, path.string(), output));
  }
  return violations;
}

std::vector<std::string> unfinished_store_conflicts(const NamedFiles& files, const std::string& output, const fs::path& store) {
  return unfinished_conflicts(files, output, unfinished_store(store));
}

std::vector<std::string> conflicts_with_run(const NamedFiles& files, const fs::path& folder, bool parts) {
  std::vector<fs::path> folders = parts ? folders_of_parts(folder) : std::vector{folder};
  std::ranges::transform(folders, folders.begin(), destination);
  std::vector<std::string> violations;
  std::set<std::pair<std::string, fs::path>> told;  // of those in one folder one is enough
  for (const auto& [name, file] : files) {
    if (file.empty() || !(is_of_run(file, folders) || is_of_run(link_target(file), folders))) continue;
    if (!told.emplace(name, file.parent_path()).second) continue;
    violations.push_back(fmt::format(
        "{} {} is of the files that --output replaces: give it another name, or --output another folder", name, file.string()));
  }
  if (!parts) return violations;  // output_conflicts() knows of the folder itself
  for (const fs::path& part : folders) append(violations, unfinished_conflicts(files, "--output", part / kUnfinished));
  return violations;
}

void check_writable(const NamedFiles& files) {
  std::error_code ignored;
  for (const auto& [name, path] : files) {
    if (path.empty() || is_stream(path)) continue;
    if (fs::is_directory(path, ignored)) demand(call_failed(path, EISDIR, ErrorKind::kCannotWrite));
    OutputFile::create(path).value();
  }
}

std::string extension_of(const fs::path& path) {
  return boost::to_lower_copy(path.extension().string());
}

bool names_map_file(const fs::path& path) {
  const std::string extension = extension_of(path);
  std::error_code ignored;
  const bool is_map = extension == ".g2o" || extension == ".tum" || extension == ".csv" || extension == ".mat";
  return is_stream(path) || (is_map && !fs::is_directory(path, ignored));
}

bool is_written_as_g2o(const fs::path& path) {
  const std::string extension = extension_of(path);
  return extension != ".tum" && extension != ".csv" && extension != ".mat";
}

bool goes_by_extension(const fs::path& path) {
  std::error_code ignored;
  return path.has_extension() && !is_stream(path) && !fs::is_directory(path, ignored);
}

std::vector<std::string> demand_extension(const fs::path& path) {
  std::error_code ignored;
  if (path.empty() || path.has_extension() || names_map_file(path) || fs::is_directory(path, ignored)) {
    return check_extension(path);
  }
  return {fmt::format("--output: {} has none of the extensions of a map, .g2o, .tum, .csv and .mat", path.string())};
}

std::vector<std::string> check_extension(const fs::path& path, bool takes_folder) {
  const bool is_folder = !path.empty() && !path.has_filename();
  if (is_folder && !takes_folder)
    return {fmt::format("--output: {} is a folder, as `mapjoin run` writes a map; name a file", path.string())};
  if (!goes_by_extension(path) || names_map_file(path)) return {};
  return {fmt::format("--output: {} has none of the extensions of a map, .g2o, .tum, .csv and .mat{}", path.string(),
                      takes_folder ? " (a new folder has none, or ends in /)" : "")};
}

std::string trajectory_of(std::uint32_t session) {
  return fmt::format("trajectory_{}.tum", session);
}

std::string folder_of_part(std::size_t part) {
  return fmt::format("part_{}", part + 1);
}

std::vector<fs::path> folders_of_parts(const fs::path& folder) {
  std::vector<fs::path> folders = entries_of(folder);
  std::erase_if(folders, [](const fs::path& part) { return !number_between(part.filename().native(), "part_", ""); });
  return folders;
}

bool is_file_of_run(const std::string& name) {
  return name == kReportOfRun || std::ranges::find(kFilesOfRun, name) != kFilesOfRun.end() || is_extra_of_run(name) ||
         number_between(name, "trajectory_", ".tum");
}

std::vector<std::string> files_of_former_run(const fs::path& folder) {
  const fs::path own = folder / kReportOfRun;
  std::error_code ignored;
  if (!fs::is_regular_file(fs::symlink_status(own, ignored))) return {};
  std::vector<std::string> written;
  try {
    std::ifstream file(own);
    written = Json::parse(file).at("files").get<std::vector<std::string>>();
  } catch (const Json::exception&) {
    return {};  // it is no report of ours
  }
  const auto is_report = [](const fs::path& path) { return path.filename() == kReportOfRun; };
  const auto report = std::ranges::find_if(written, is_report);
  std::vector<std::string> names;
  for (const fs::path path : written) {
    const bool is_beside = report != written.end() && path.parent_path() == fs::path(*report).parent_path();
    if (is_beside && is_file_of_run(path.filename())) names.push_back(path.filename());
  }
  return names;
}

std::vector<fs::path> other_runs_in(const fs::path& folder, const std::vector<fs::path>& written) {
  std::vector<fs::path> folders = folders_of_parts(folder);
  folders.insert(folders.begin(), folder);
  std::erase_if(folders, [&](const fs::path& run) {
    return std::ranges::find(written, run) != written.end() || files_of_former_run(run).empty();
  });
  return folders;
}

std::vector<fs::path> map_files(const fs::path& path) {
  if (extension_of(path) != ".csv") return {path};
  return {path, fs::path(path).replace_extension(".features.csv")};
}

template <int Dim>
Expected<void> write_map_file(const GlobalMap<Dim>& map, const Log<Dim>* log, const fs::path& path) {
  if (is_written_as_g2o(path)) return write_g2o(map, log, path);
  const std::vector<fs::path> files = map_files(path);
  if (files.size() > 1) return write_csv(map, files[0], files[1]);
  return extension_of(path) == ".mat" ? write_mat_map(map, path) : write_tum(map, path);
}

template Expected<void> write_map_file(const GlobalMap<2>&, const Log<2>*, const fs::path&);
template Expected<void> write_map_file(const GlobalMap<3>&, const Log<3>*, const fs::path&);

}  // namespace mapjoin::apps
