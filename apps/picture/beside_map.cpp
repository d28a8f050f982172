// SPDX-License-Identifier: BSD-3-Clause
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

[[noreturn]] void fail_not_of_map(const fs::path& file) {
  fail(ErrorKind::kBadInput, file.string() + ": is not of the map beside it");
}

/// What `take` makes of the JSON in a file. What it does not find there, or finds to be something else, is bad input.
template <typename Take>
auto from_json(const fs::path& file, Take&& take) {
  const FileBytes bytes = FileBytes::read(file).value();
  try {
    return take(Json::parse(bytes.view()));
  } catch (const Json::exception&) {
    fail(ErrorKind::kBadInput, file.string() + ": is not as mapjoin writes it");
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

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

}  // namespace

template <int Dim>
void read_covariances_beside(const fs::path& path, GlobalMap<Dim>& map) {
  fs::path file = covariance_file(path);
  if (path.filename() == kMapOfRun && !is_there(file)) file = path.parent_path() / "covariances.json";
  if (!is_there(file)) return;
  from_json(file, [&](const Json& json) {
    const Json& poses = json.at("poses");
    const Json& features = json.at("features");
    if (json.at("dimension") != Dim || !are_of(poses, map.pose_ids) || features.size() != map.features.size()) {
      fail_not_of_map(file);
    }
    map.pose_covariances = covariances_of<PoseIndex, PoseMatrix<Dim>>(poses);
    map.feature_covariances = covariances_of<FeatureIndex, PointMatrix<Dim>>(features);
  });
}

std::vector<MapFit> read_fits_beside(const fs::path& path, const PoseIds& poses) {
  const fs::path file = path.parent_path() / "report.json";
  if (path.filename() != kMapOfRun || !is_there(file)) return {};
  return from_json(file, [&](const Json& json) {
    std::vector<MapFit> fits;
    const IndexOf index_of(poses);
    for (const Json& line : json.at("join").at("maps")) {
      const PoseId id = pose_id(line);
      if (!line.contains("end") || id.session != 0) return std::vector<MapFit>();
      const auto base = index_of(id);
      const auto end = index_of(pose_id(line, "end"));
      if (!base || !end || *end < *base) fail_not_of_map(file);
      fits.push_back({*base, *end, line.at("chi2").get<double>(), line.at("rows").get<std::int64_t>()});
    }
    return fits;
  });
}

template void read_covariances_beside(const fs::path&, GlobalMap<2>&);
template void read_covariances_beside(const fs::path&, GlobalMap<3>&);

}  // namespace mapjoin::apps
