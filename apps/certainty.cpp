// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <apps/certainty.hpp>
#include <apps/position.hpp>
#include <apps/report/json.hpp>
#include <cmath>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {
namespace {

/// The standard deviation of a rotation (rad).
template <int Dim>
double rotation_deviation(const PoseMatrix<Dim>& covariance) {
  return std::sqrt(covariance.template bottomRightCorner<kRotationDof<Dim>, kRotationDof<Dim>>().trace());
}

template <int Dim, typename Index, typename Covariance, typename Relation>
std::optional<Deviations::Median> medians(const Table<Index, Covariance>& covariances,
                                          const Table<Index, Relation>& relations) {
  std::vector<double> in_map, relative;
  for (const Index k : indices(covariances)) {
    if (covariances[k].isZero(0.0)) continue;  // anchored
    in_map.push_back(position_deviation<Dim>(covariances[k]));
    relative.push_back(position_deviation<Dim>(relations[k].covariance));
  }
  if (in_map.empty()) return std::nullopt;
  return Deviations::Median{median(std::move(in_map)), median(std::move(relative))};
}

template <int Dim>
Json head(const GlobalMap<Dim>& map, Estimate estimate) {
  Json held = Json::array();
  for (const PoseIndex pose : map.gauge) held.push_back(map.pose_ids[pose]);
  return {{"schema_version", 1},
          {"dimension", Dim},
          {"estimate", estimate},
          {"gauge", {{"held_poses", held}}},
          {"pose_coordinates", step_names<Dim>()},
          {"feature_coordinates", step_names<Dim>(Dim)}};
}

/// Writes a line per pose or feature, one at a time, for maps can be large; with the upper triangle of its covariance, row by
/// row.
template <typename Index, typename Id, typename Value, typename Covariance>
void write_list(const char* key, const Table<Index, Id>& ids, const Table<Index, Value>& values,
                const Table<Index, Covariance>& covariances, OutputFile& file) {
  file.write(std::string(",\n\"") + key + "\": [");
  for (const Index k : indices(covariances)) {
    Json line = ids[k];
    for (const double coordinate : *position_of(values[k])) line["position"].push_back(coordinate);
    each_of_upper_triangle(covariances[k], [&](double entry) { line["covariance"].push_back(entry); });
    file.write((k == 0 ? "\n" : ",\n") + line.dump());
  }
  file.write("\n]");
}

/// Adds the session and key of the parent; empty for the World.
template <int Dim>
void put_parent(const GlobalMap<Dim>& map, PoseIndex parent, TextLine& line) {
  if (parent == kWorld) {
    line.add("").add("");
  } else {
    const PoseId& id = map.pose_ids[parent];
    line.add(id.session).add(key_text(id.key));
  }
}

template <int Dim>
void put_pose(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals, PoseIndex pose, TextLine& line) {
  const PoseRelation<Dim>& relation = marginals.relations.poses[pose];
  line.add("pose").add(map.pose_ids[pose].session).add(key_text(map.pose_ids[pose].key));
  put_parent(map, relation.parent, line);
  line.add(relation.value).template add_symmetric<kPoseDof<Dim>>(relation.covariance);
  line.add(position_deviation<Dim>(relation.covariance)).add(position_deviation<Dim>(marginals.poses[pose]));
  line.add(rotation_deviation<Dim>(relation.covariance)).add(rotation_deviation<Dim>(marginals.poses[pose]));
}

/// Adds the columns of a feature; session and rotation, which features lack, stay empty.
template <int Dim>
void put_feature(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals, FeatureIndex feature, TextLine& line) {
  const FeatureRelation<Dim>& relation = marginals.relations.features[feature];
  line.add("feature").add("").add(key_text(map.feature_ids[feature].key));
  put_parent(map, relation.parent, line);
  line.template add<Dim>(relation.value).add(Dim == 2 ? "" : ",,,");
  for (int i = 0; i < kPoseDof<Dim>; ++i) {
    for (int j = i; j < kPoseDof<Dim>; ++j) j < Dim ? line.add(relation.covariance(i, j)) : line.add("");
  }
  line.add(position_deviation<Dim>(relation.covariance)).add(position_deviation<Dim>(marginals.features[feature]));
  line.add("").add("");
}

}  // namespace

template <int Dim>
double extent_of(const GlobalMap<Dim>& map) {
  Eigen::AlignedBox<double, Dim> box;
  for (const Pose<Dim>& pose : map.poses) box.extend(pose.translation);
  for (const Point<Dim>& feature : map.features) box.extend(feature);
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

template <int Dim>
Deviations deviations_of(const MarginalCovariances<Dim>& marginals) {
  const Relations<Dim>& relations = marginals.relations;
  return {medians<Dim>(marginals.poses, relations.poses), medians<Dim>(marginals.features, relations.features)};
}

template <int Dim>
Expected<void> write_covariances(const GlobalMap<Dim>& map, Estimate estimate, const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string text = head(map, estimate).dump();
  text.pop_back();  // The object goes on.
  file->write(text);
  write_list("poses", map.pose_ids, map.poses, map.pose_covariances, *file);
  write_list("features", map.feature_ids, map.features, map.feature_covariances, *file);
  file->write("}\n");
  return file->commit();
}

template <int Dim>
Expected<void> write_relations(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals,
                               const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  TextLine line(',');
  line.add("kind,session,id,parent_session,parent").add(Dim == 2 ? "x,y,phi" : "x,y,z,qx,qy,qz,qw");
  line.add_covariance_names(step_names<Dim>()).add("position_sd,position_sd_in_map,rotation_sd,rotation_sd_in_map");
  line.write_to(*file);
  for (const PoseIndex pose : marginals.relations.order) {
    put_pose(map, marginals, pose, line);
    line.write_to(*file);
  }
  for (const FeatureIndex f : indices(map.features)) {
    put_feature(map, marginals, f, line);
    line.write_to(*file);
  }
  return file->commit();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                            \
  template double extent_of(const GlobalMap<Dim>&);                                                         \
  template Deviations deviations_of(const MarginalCovariances<Dim>&);                                       \
  template Expected<void> write_covariances(const GlobalMap<Dim>&, Estimate, const std::filesystem::path&); \
  template Expected<void> write_relations(const GlobalMap<Dim>&, const MarginalCovariances<Dim>&, const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
