// SPDX-License-Identifier: BSD-3-Clause
#include <apps/map_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {
namespace {

using Json = nlohmann::ordered_json;

Json named(const PoseId& id) {
  return {{"session", id.session}, {"pose", id.key}};
}
Json named(const FeatureId& id) {
  return {{"feature", id.key}};
}

/// The upper triangle, row by row.
template <int Size>
std::vector<double> upper_triangle(const Matrix<Size>& M) {
  std::vector<double> entries;
  for (int i = 0; i < Size; ++i) {
    for (int j = i; j < Size; ++j) entries.push_back(M(i, j));
  }
  return entries;
}

template <int Dim>
Json head(const GlobalMap<Dim>& map, Estimate estimate) {
  Json held = Json::array();
  for (const Index pose : map.gauge) held.push_back(named(map.pose_ids[static_cast<std::size_t>(pose)]));
  return {{"schema_version", 1},
          {"dimension", Dim},
          {"estimate", to_string(estimate)},
          {"gauge", {{"held_poses", held}}},
          {"pose_coordinates", step_names<Dim>()},
          {"feature_coordinates", step_names<Dim>(Dim)}};
}

/// One line per pose or feature, written as it comes: maps can be large.
template <typename Id, typename Covariance>
void write_list(const char* key, const std::vector<Id>& ids, const std::vector<Covariance>& covariances, OutputFile& file) {
  file.write(std::string(",\n\"") + key + "\": [");
  for (std::size_t k = 0; k < covariances.size(); ++k) {
    Json line = named(ids[k]);
    line["covariance"] = upper_triangle<Covariance::RowsAtCompileTime>(covariances[k]);
    file.write((k == 0 ? "\n" : ",\n") + line.dump());
  }
  file.write("\n]");
}

}  // namespace

std::filesystem::path covariance_file(const std::filesystem::path& map) {
  return std::filesystem::path(map).replace_extension(".covariances.json");
}

template <int Dim>
Expected<void> write_covariances(const GlobalMap<Dim>& map, Estimate estimate, const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string text = head(map, estimate).dump();
  text.pop_back();  // The object goes on.
  file->write(text);
  write_list("poses", map.pose_ids, map.pose_covariances, *file);
  write_list("features", map.feature_ids, map.feature_covariances, *file);
  file->write("}\n");
  return file->commit();
}

template Expected<void> write_covariances(const GlobalMap<2>&, Estimate, const std::filesystem::path&);
template Expected<void> write_covariances(const GlobalMap<3>&, Estimate, const std::filesystem::path&);

}  // namespace mapjoin::apps
