// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a study hands over: a table for people, JSON for programs, and a folder of files.

#include <apps/commands/command_run.hpp>
#include <apps/output_folder.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin::apps {

struct StudyOutput {
  std::string table;
  std::string json;
  std::vector<std::pair<std::string, std::string>> files;  ///< Of the folder: name and content.
};

/// Writes the folder and the report, then the table, or with `--report -` the JSON, to standard output.
Expected<void> hand_over(const StudyOutput& output, CommandRun& command_run, std::optional<OutputFolder>& folder);

/// A command that studies a log or local maps: `study` gives figures, `output_of` what is handed over of them.
template <typename Study, typename Output>
Expected<ExitCode> run_study(CommandRun& command_run, Study&& study, Output&& output_of) {
  auto folder = output_folder(command_run.options().output);
  if (!folder) return tl::unexpected(folder.error());
  if (auto ready = command_run.check_report(); !ready) return tl::unexpected(ready.error());
  const auto found = command_run.with_log_or_maps(study);
  if (!found) return tl::unexpected(found.error());
  return command_run.check_interrupted().and_then([&] { return hand_over(output_of(*found), command_run, *folder); }).map([] {
    return ExitCode::kDone;
  });
}

}  // namespace mapjoin::apps
