// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/extra_files.hpp>
#include <array>
#include <mapjoin/io/run_folder.hpp>
#include <system_error>

namespace mapjoin::apps {
namespace fs = std::filesystem;
namespace {

constexpr auto kExtraFiles =
    std::to_array<ExtraFile>({{Extra::kCovariances, "--covariances", "covariances.json", ".covariances.json"},
                              {Extra::kRelations, "--relations", "relations.csv", ".relations.csv"},
                              {Extra::kAssociations, "--associate", "associations.csv", ".associations.csv"},
                              {Extra::kRejected, "--robust", "rejected.csv", ".rejected.csv"},
                              {Extra::kInliers, "--robust", "inliers.g2o", nullptr},
                              {Extra::kGeographic, "--gps", "poses.geographic.csv", ".geographic.csv"},
                              {Extra::kGeoJson, "--gps", "map.geojson", ".geojson"}});

const ExtraFile& row_of(Extra extra) {
  return *std::ranges::find(kExtraFiles, extra, &ExtraFile::extra);
}

bool is_asked(Extra extra, const Options& options) {
  switch (extra) {
    case Extra::kCovariances:
      return options.covariances;
    case Extra::kRelations:
      return options.relations;
    case Extra::kAssociations:
      return options.association.has_value();
    case Extra::kRejected:
    case Extra::kInliers:
      return options.robust.has_value();
    default:
      return !options.gps.empty();
  }
}

}  // namespace

std::vector<ExtraFile> extra_files(const Options& options, bool has_covariances) {
  std::vector<ExtraFile> files;
  for (const ExtraFile& file : kExtraFiles) {
    const bool is_of_covariances = file.extra == Extra::kCovariances || file.extra == Extra::kRelations;
    if (is_asked(file.extra, options) && (has_covariances || !is_of_covariances)) files.push_back(file);
  }
  return files;
}

std::vector<ExtraFile> files_beside(const Options& options, bool has_covariances) {
  if (is_stream(options.output)) return {};
  std::vector<ExtraFile> files = extra_files(options, has_covariances);
  std::erase_if(files, [](const ExtraFile& file) { return !file.beside; });
  return files;
}

const char* name_in_folder(Extra extra) {
  return row_of(extra).in_folder;
}

fs::path extra_file(Extra extra, const fs::path& map) {
  return fs::path(map).replace_extension(row_of(extra).beside);
}

bool has_extra_file(Extra extra, const fs::path& map) {
  std::error_code ignored;
  const char* const in_folder = name_in_folder(extra);
  if (fs::is_directory(map, ignored)) return fs::is_regular_file(map / in_folder, ignored);
  const std::string name = map.filename().string();
  const bool may_be_of_run = name == kMapOfRun || is_extra_of_run(name);
  return fs::is_regular_file(extra_file(extra, map), ignored) ||
         (may_be_of_run && fs::is_regular_file(map.parent_path() / in_folder, ignored));
}

bool is_extra_of_run(const std::string& name) {
  return std::ranges::find(kExtraFiles, name, &ExtraFile::in_folder) != kExtraFiles.end();
}

std::vector<fs::path> extra_files_left(const fs::path& map, const std::vector<std::string>& written) {
  std::vector<fs::path> left;
  std::error_code ignored;
  for (const ExtraFile& extra : kExtraFiles) {
    if (!extra.beside) continue;
    const fs::path file = extra_file(extra.extra, map);
    if (fs::is_regular_file(file, ignored) && std::ranges::find(written, file.string()) == written.end()) left.push_back(file);
  }
  return left;
}

}  // namespace mapjoin::apps
