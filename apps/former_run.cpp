// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/former_run.hpp>
#include <apps/outputs.hpp>
#include <apps/report/json.hpp>
#include <fstream>
#include <system_error>

namespace mapjoin::apps {

namespace fs = std::filesystem;

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

}  // namespace mapjoin::apps
