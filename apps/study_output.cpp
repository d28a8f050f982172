// SPDX-License-Identifier: BSD-3-Clause
#include <apps/console.hpp>
#include <apps/study_output.hpp>
#include <mapjoin/io/output_file.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

Expected<void> write_text(const std::string& text, const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  file->write(text);
  return file->commit();
}

Expected<void> write_folder(const std::vector<StudyFile>& files, OutputFolder& folder) {
  std::vector<std::string> names;
  for (const StudyFile& file : files) {
    if (auto written = write_text(file.text, folder.aside(file.name)); !written) return written;
    names.push_back(file.name);
  }
  return folder.commit(names);
}

}  // namespace

Expected<std::optional<OutputFolder>> study_folder(const Options& options) {
  if (options.output.empty()) return std::nullopt;
  return OutputFolder::create(options.output).map([](OutputFolder&& folder) { return std::optional(std::move(folder)); });
}

NamedFiles study_files(const Options& options, const std::string& input, const std::vector<std::string>& names) {
  NamedFiles files = {{input, options.input}, {"--report", options.report_on_stdout() ? "" : options.report}};
  if (options.output.empty()) return files;
  for (const std::string& name : names) files.emplace_back("--output", options.output / name);
  return files;
}

Expected<void> hand_over(const StudyOutput& output, const Options& options, std::optional<OutputFolder>& folder) {
  if (folder) {
    if (auto written = write_folder(output.files, *folder); !written) return written;
  }
  if (options.report_on_stdout()) return write_stdout(output.json);
  if (!options.report.empty()) {
    if (auto written = write_text(output.json, options.report); !written) return written;
  }
  return options.quiet ? Expected<void>() : write_stdout(output.table);
}

}  // namespace mapjoin::apps
