// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a study hands over: a table for people, JSON for programs, and a folder of files.

#include <apps/options.hpp>
#include <apps/output_folder.hpp>
#include <mapjoin/model/error.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct StudyFile {
  std::string name;
  std::string text;
};

struct StudyOutput {
  std::string table;
  std::string json;
  std::vector<StudyFile> files;  ///< Of the folder.
};

/// Writes the folder and the report, then the table, or with `--report -` the JSON, to standard output.
Expected<void> hand_over(const StudyOutput& output, const Options& options, std::optional<OutputFolder>& folder);

}  // namespace mapjoin::apps
