// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Earlier runs in the folder of a run, known by their reports.

#include <filesystem>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// The files that an earlier run wrote into a folder, by its report there, which lists itself among them.
std::vector<std::string> files_of_former_run(const std::filesystem::path& folder);

/// The folder of a run and those of parts in it that hold a run, except the folders `written`.
std::vector<std::filesystem::path> other_runs_in(const std::filesystem::path& folder,
                                                 const std::vector<std::filesystem::path>& written);

}  // namespace mapjoin::apps
