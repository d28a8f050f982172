// SPDX-License-Identifier: BSD-3-Clause
#include <apps/map_file.hpp>
#include <apps/report/deviations.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>

namespace mapjoin::apps {
namespace {

template <int Dim>
void put_header(TextLine& line) {
  line.add("kind,session,id,parent_session,parent").add(Dim == 2 ? "x,y,phi" : "x,y,z,qx,qy,qz,qw");
  line.add_covariance_names(step_names<Dim>());
  line.add("position_sd,position_sd_in_map,rotation_sd,rotation_sd_in_map");
}

/// Of the World, nothing.
template <int Dim>
void put_parent(const GlobalMap<Dim>& map, Index parent, TextLine& line) {
  if (parent == kWorld) {
    line.add("").add("");
  } else {
    const PoseId& id = map.pose_ids[static_cast<std::size_t>(parent)];
    line.add(id.session).add(id.key);
  }
}

template <int Dim>
void put_pose(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals, std::size_t pose, TextLine& line) {
  const PoseRelation<Dim>& relation = marginals.relations.poses[pose];
  line.add("pose").add(map.pose_ids[pose].session).add(map.pose_ids[pose].key);
  put_parent(map, relation.parent, line);
  line.add(relation.placement).template add_symmetric<kPoseDof<Dim>>(relation.covariance);
  line.add(position_deviation<Dim>(relation.covariance)).add(position_deviation<Dim>(marginals.poses[pose]));
  line.add(rotation_deviation<Dim>(relation.covariance)).add(rotation_deviation<Dim>(marginals.poses[pose]));
}

/// What features have not, session and rotation, is left empty.
template <int Dim>
void put_feature(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals, std::size_t feature, TextLine& line) {
  const FeatureRelation<Dim>& relation = marginals.relations.features[feature];
  line.add("feature").add("").add(map.feature_ids[feature].key);
  put_parent(map, relation.parent, line);
  line.template add<Dim>(relation.placement).add(Dim == 2 ? "" : ",,,");
  for (int i = 0; i < kPoseDof<Dim>; ++i) {
    for (int j = i; j < kPoseDof<Dim>; ++j) {
      if (j < Dim) {
        line.add(relation.covariance(i, j));
      } else {
        line.add("");
      }
    }
  }
  line.add(position_deviation<Dim>(relation.covariance)).add(position_deviation<Dim>(marginals.features[feature]));
  line.add("").add("");
}

}  // namespace

std::filesystem::path relation_file(const std::filesystem::path& map) {
  return std::filesystem::path(map).replace_extension(".relations.csv");
}

template <int Dim>
Expected<void> write_relations(const GlobalMap<Dim>& map, const MarginalCovariances<Dim>& marginals,
                               const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  TextLine line(',');
  put_header<Dim>(line);
  line.write_to(*file);
  for (const Index pose : marginals.relations.order) {
    put_pose(map, marginals, static_cast<std::size_t>(pose), line);
    line.write_to(*file);
  }
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    put_feature(map, marginals, f, line);
    line.write_to(*file);
  }
  return file->commit();
}

template Expected<void> write_relations(const GlobalMap<2>&, const MarginalCovariances<2>&, const std::filesystem::path&);
template Expected<void> write_relations(const GlobalMap<3>&, const MarginalCovariances<3>&, const std::filesystem::path&);

}  // namespace mapjoin::apps
