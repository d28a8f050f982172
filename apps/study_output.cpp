// SPDX-License-Identifier: BSD-3-Clause
#include <apps/console.hpp>
#include <apps/study_output.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

Expected<void> write_folder(const std::vector<StudyFile>& files, OutputFolder& folder) {
  std::vector<std::string> names;
  for (const StudyFile& file : files) {
    if (auto written = write_file(folder.aside(file.name), file.text); !written) return written;
    names.push_back(file.name);
  }
  return folder.commit(names);
}

}  // namespace

Expected<void> hand_over(const StudyOutput& output, const Options& options, std::optional<OutputFolder>& folder) {
  if (folder) {
    if (auto written = write_folder(output.files, *folder); !written) return written;
  }
  if (options.report_on_stdout()) return write_stdout(output.json);
  if (!options.report.empty()) {
    if (auto written = write_file(options.report, output.json); !written) return written;
  }
  return options.quiet ? Expected<void>() : write_stdout(output.table);
}

}  // namespace mapjoin::apps
