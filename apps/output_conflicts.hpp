// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// That no file of a command is written over another one of it.

#include <apps/commands/options.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

/// Files by what the command takes them for, such as "--output".
using NamedFiles = std::vector<std::pair<std::string, std::filesystem::path>>;

/// In words, any two that are the same file, or would be: by links and by names, where one is yet to come. Empty paths and
/// what is there but not a regular file, such as /dev/null, are like no other.
std::vector<std::string> output_conflicts(const NamedFiles& files);

/// The input, under the name of its argument, the output, the truth, unless it is the input, and the report.
NamedFiles files_of(const Options& options, const std::string& argument);

/// As files_of(), with what is written beside a map that is one file: features of a CSV map, covariances, relations.
NamedFiles files_of_map(const Options& options, const std::string& argument);

/// As files_of(), with the files of these names in the folder that the output is, where there is one.
NamedFiles files_of_folder(const Options& options, const std::string& argument, const std::vector<std::string>& names);

}  // namespace mapjoin::apps
