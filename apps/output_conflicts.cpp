// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/map_file.hpp>
#include <apps/output_conflicts.hpp>
#include <system_error>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;

bool is_same(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code ignored;
  if (fs::exists(a, ignored) || fs::exists(b, ignored)) {
    return fs::is_regular_file(a, ignored) && fs::equivalent(a, b, ignored);
  }
  return fs::weakly_canonical(a, ignored) == fs::weakly_canonical(b, ignored);
}

}  // namespace

std::vector<std::string> output_conflicts(const NamedFiles& files) {
  std::vector<std::string> violations;
  for (auto later = files.begin(); later != files.end(); ++later) {
    for (auto earlier = files.begin(); earlier != later; ++earlier) {
      if (!is_same(earlier->second, later->second)) continue;
      violations.push_back(fmt::format("{} and {} are one file, {}", earlier->first, later->first, later->second.string()));
    }
  }
  return violations;
}

NamedFiles files_of(const Options& options, const std::string& argument) {
  NamedFiles files = {{argument, options.input}, {"--output", options.output}};
  if (options.truth != options.input) files.emplace_back("--truth", options.truth);
  if (!options.report_on_stdout()) files.emplace_back("--report", options.report);
  return files;
}

NamedFiles files_of_map(const Options& options, const std::string& argument) {
  NamedFiles files = files_of(options, argument);
  if (options.output.empty()) return files;
  const std::vector<fs::path> written = map_files(options.output);
  for (auto beside = written.begin() + 1; beside != written.end(); ++beside) files.emplace_back("--output", *beside);
  if (options.covariances) files.emplace_back("--covariances", covariance_file(options.output));
  if (options.relations) files.emplace_back("--relations", relation_file(options.output));
  return files;
}

NamedFiles files_of_folder(const Options& options, const std::string& argument, const std::vector<std::string>& names) {
  NamedFiles files = files_of(options, argument);
  if (options.output.empty()) return files;
  for (const std::string& name : names) files.emplace_back("--output", options.output / name);
  return files;
}

}  // namespace mapjoin::apps
