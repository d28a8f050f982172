// SPDX-License-Identifier: BSD-3-Clause
#include <apps/commands/study.hpp>
#include <mapjoin/io/files/output_file.hpp>

namespace mapjoin::apps {

Expected<void> hand_over(const StudyOutput& output, CommandRun& command_run, std::optional<OutputFolder>& folder) {
  std::vector<std::string> names;
  for (const auto& [name, text] : output.files) {
    if (!folder) break;
    if (auto written = write_file(folder->aside(name), text); !written) return written;
    names.push_back(name);
  }
  if (folder) {
    if (auto done = folder->commit(names); !done) return done;
  }
  return command_run.tell([&] { return output.json; }, [&] { return output.table; });
}

}  // namespace mapjoin::apps
