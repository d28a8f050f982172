// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Calls of the command that write files, and the files that they leave.

#include <cstdlib>
#include <functional>
#include <map>
#include <tests/apps/command.hpp>

namespace mapjoin::testing {

/// Contents of files by their names.
using Files = std::map<std::string, std::string>;

/// The bytes of every file in a folder and below it; for a whole report, in which times differ, the words "a report".
inline Files files_in(const std::filesystem::path& folder) {
  Files files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::string content = content_of(entry.path());
    const bool has_times = entry.path().extension() == ".json" && entry.path().filename() != "covariances.json";
    if (has_times && nlohmann::json::accept(content)) content = "a report";
    files[std::filesystem::relative(entry.path(), folder).string()] = std::move(content);
  }
  return files;
}

/// A call that writes into the folder that it is given.
struct WritingCall {
  std::function<std::vector<std::string>(const std::string& folder)> words;
  bool replaces = true;  ///< True if it replaces files that are there already.
};

/// The call of `words`, followed by `name` in the folder and --quiet.
inline WritingCall writing_call(std::vector<std::string> words, const std::string& name, bool replaces = true) {
  return {[=](const std::string& folder) {
            std::vector<std::string> all = words;
            all.insert(all.end(), {folder + "/" + name, "--quiet"});
            return all;
          },
          replaces};
}

/// Calls that write and take little time, on a log and a store of its maps.
inline std::vector<WritingCall> writing_calls(const std::string& log, const std::string& store) {
  return {writing_call({"run", log, "--covariances", "--relations", "-o"}, "map"),
          writing_call({"join", store, "--covariances", "-o"}, "map.csv"),
          writing_call({"solve", log, "-o"}, "map.g2o"),
          writing_call({"plot", store, "-o"}, "map.html"),
          writing_call({"convert", log}, "log.mat"),
          writing_call({"convert", store, "--to", "maps-text"}, "maps", false),
          writing_call({"simulate", "--poses", "1000", "-o"}, "log.g2o")};
}

/// The number of repetitions of a test: that in the environment variable `name`, or `usually` if it is not set.
inline int how_often(const char* name, int usually) {
  const char* asked = std::getenv(name);
  return asked ? std::atoi(asked) : usually;
}

}  // namespace mapjoin::testing
