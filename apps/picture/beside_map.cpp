// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/outputs.hpp>
#include <apps/picture/load.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace mapjoin::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// The name of the map in the folder of a run.
constexpr const char* kMapOfRun = "map.g2o";

tl::unexpected<Error> not_of_map(const fs::path& file) {
  return bad_input(fmt::format("{}: is not of the map beside it", file.string()));
}

/// What `take` makes of the JSON in a file. What it does not find there, or finds to be something else, is bad input.
template <typename Take>
auto from_json(const fs::path& file, Take&& take) -> decltype(take(Json())) {
  const auto bytes = FileBytes::read(file);
  if (!bytes) return tl::unexpected(bytes.error());
  try {
    return take(Json::parse(bytes->view()));
  } catch (const Json::exception&) {
    return bad_input(fmt::format("{}: is not as mapjoin writes it", file.string()));
  }
}

/// Symmetric, from its upper triangle, row by row; throws where there are not as many numbers.
template <int Size>
Matrix<Size> symmetric(const Json& upper) {
  Matrix<Size> M;
  std::size_t next = 0;
  for (int i = 0; i < Size; ++i) {
    for (int j = i; j < Size; ++j) M(i, j) = M(j, i) = upper.at(next++).get<double>();
  }
  return M;
}

template <typename Index, typename Covariance>
Table<Index, Covariance> covariances_of(const Json& lines) {
  Table<Index, Covariance> covariances;
  for (const Json& line : lines) covariances.push_back(symmetric<Covariance::RowsAtCompileTime>(line.at("covariance")));
  return covariances;
}

PoseId pose_id(const Json& line, const char* key = "pose") {
  return {line.at("session").get<std::uint32_t>(), line.at(key).get<std::uint64_t>()};
}

/// Whether the lines are of these poses, in their order. Those of further sessions have other names in a g2o file.
bool are_of(const Json& lines, const PoseIds& poses) {
  if (lines.size() != poses.size()) return false;
  for (const PoseIndex p : indices(poses)) {
    const PoseId id = pose_id(lines[p.position()]);
    if (id.session == 0 && id != poses[p]) return false;
  }
  return true;
}

template <int Dim>
Expected<void> take_covariances(const fs::path& file, const Json& json, GlobalMap<Dim>& map) {
  const Json& poses = json.at("poses");
  const Json& features = json.at("features");
  if (json.at("dimension") != Dim || !are_of(poses, map.pose_ids) || features.size() != map.features.size()) {
    return not_of_map(file);
  }
  map.pose_covariances = covariances_of<PoseIndex, PoseMatrix<Dim>>(poses);
  map.feature_covariances = covariances_of<FeatureIndex, PointMatrix<Dim>>(features);
  return {};
}

template <int Dim>
Expected<std::vector<MapFit>> take_fits(const fs::path& file, const Json& json, const GlobalMap<Dim>& map) {
  std::vector<MapFit> fits;
  const IndexOf index_of(map.pose_ids);
  for (const Json& line : json.at("join").at("maps")) {
    const PoseId id = pose_id(line);
    if (!line.contains("end") || id.session != 0) return std::vector<MapFit>();
    const auto base = index_of(id);
    const auto end = index_of(pose_id(line, "end"));
    if (!base || !end || *end < *base) return not_of_map(file);
    fits.push_back({*base, *end, line.at("chi2").get<double>(), line.at("rows").get<std::int64_t>()});
  }
  return fits;
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

}  // namespace

template <int Dim>
Expected<void> read_covariances_beside(const fs::path& path, GlobalMap<Dim>& map) {
  fs::path file = covariance_file(path);
  if (path.filename() == kMapOfRun && !is_there(file)) file = path.parent_path() / "covariances.json";
  if (!is_there(file)) return {};
  return from_json(file, [&](const Json& json) { return take_covariances(file, json, map); });
}

template <int Dim>
Expected<std::vector<MapFit>> read_fits_beside(const fs::path& path, const GlobalMap<Dim>& map) {
  const fs::path file = path.parent_path() / "report.json";
  if (path.filename() != kMapOfRun || !is_there(file)) return std::vector<MapFit>();
  return from_json(file, [&](const Json& json) { return take_fits(file, json, map); });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                     \
  template Expected<void> read_covariances_beside(const fs::path&, GlobalMap<Dim>&); \
  template Expected<std::vector<MapFit>> read_fits_beside(const fs::path&, const GlobalMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
