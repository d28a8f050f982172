// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/measured.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// Puts an observation from sensor offset 0, the only one written, which is the identity.
Fault put_point_seen_from_0(const MeasuredPoint<3>& point, TextLine& line) {
  return put_plain_point<3>(point, line.add(0));
}

template <int Dim>
bool is_tag_of(std::string_view tag);

/// True for the tags of data that programs put between the lines of a graph: scans, images, names.
bool is_sensor_data(std::string_view tag) {
  return tag.starts_with("ROBOTLASER") || tag.starts_with("RAWLASER") || tag.starts_with("DATA") || tag.ends_with("_DATA") ||
         tag == "VERTEX_TAG" || tag == "VERTEX_ELLIPSE";
}

using Kind = PriorTag::Kind;
using Sensor = PriorTag::Sensor;
constexpr std::array kPriorsOfPlane = std::to_array<PriorTag>(
    {{"EDGE_PRIOR_SE2", Kind::kPose}, {"EDGE_PRIOR_SE2_XY", Kind::kPosition}, {"EDGE_PRIOR_XY", Kind::kFeature}});
/// The priors of g2o, then those of hdl_graph_slam.
constexpr std::array kPriorsOfSpace = std::to_array<PriorTag>({{"EDGE_SE3_PRIOR", Kind::kPose, Sensor::kNamed},
                                                               {"EDGE_SE3_XYZ_PRIOR", Kind::kPosition, Sensor::kIgnored},
                                                               {"EDGE_POINTXYZ_PRIOR", Kind::kFeature},
                                                               {"EDGE_SE3_PRIORXYZ", Kind::kPosition},
                                                               {"EDGE_SE3_PRIORXY", Kind::kPlanar}});

constexpr EdgeText<2> kPlane{.name = "g2o files",
                             .edge_tag = "EDGE_SE2",
                             .observation_tag = "EDGE_SE2_XY",
                             .pose_tag = "VERTEX_SE2",
                             .feature_tag = "VERTEX_XY",
                             .one_numbering = true,
                             .has_g2o_lines = true,
                             .priors = kPriorsOfPlane,
                             .is_passed_over = is_sensor_data,
                             .is_of_other_dimension = is_tag_of<3>,
                             .read_edge = read_g2o_edge<2>,
                             .read_point = read_g2o_point<2>,
                             .read_pose_prior = read_g2o_pose_prior<2>};
constexpr EdgeText<3> kSpace{.name = "g2o files",
                             .edge_tag = "EDGE_SE3:QUAT",
                             .offset_line = "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1",
                             .observation_tag = "EDGE_SE3_TRACKXYZ",
                             .pose_tag = "VERTEX_SE3:QUAT",
                             .feature_tag = "VERTEX_TRACKXYZ",
                             .one_numbering = true,
                             .has_g2o_lines = true,
                             .priors = kPriorsOfSpace,
                             .is_passed_over = is_sensor_data,
                             .is_of_other_dimension = is_tag_of<2>,
                             .read_edge = read_g2o_edge<3>,
                             .read_point = read_g2o_point<3>,
                             .read_pose_prior = read_g2o_pose_prior<3>,
                             .put_point = put_point_seen_from_0};

template <int Dim>
constexpr const EdgeText<Dim>& format() {
  if constexpr (Dim == 2) {
    return kPlane;
  } else {
    return kSpace;
  }
}

template <int Dim>
bool is_tag_of(std::string_view tag) {
  return format<Dim>().has_tag(tag);
}

/// What a written file says first of its information matrices.
constexpr std::string_view kOwnInformation =
    "Information matrices weigh the difference between measured and predicted relative pose:";

/// kUsage if the options turn information matrices of a text that says itself that they are in the conventions used inside.
Expected<void> check_conventions(const TextScanner& text, const ReadOptions& options) {
  if (!options.turns_information() || text.left().find(kOwnInformation) == std::string_view::npos) return {};
  return tl::unexpected(Error{ErrorKind::kUsage, text.source() +
                                                     ": says what its information matrices weigh, as files that mapjoin wrote "
                                                     "do; leave --g2o-error and --rotation-information out"});
}

/// The contents of a g2o file over these poses and features, yet to be filled.
template <int Dim>
EdgeTextContents<Dim> contents_of(std::string_view source, const PoseIds& poses, const FeatureIds& features) {
  return {
      source,
      poses,
      features,
      {std::string(kOwnInformation),
       Dim == 2 ? "translation in the frame of the first pose, then heading."
                : "translation in the frame of the first pose, then the rotation vector (not the quaternion).",
       "One numbering: keys of features and of sessions beyond the first are moved by a power of ten where they met others."}};
}

/// The vertices of a log, fixed poses at the value they are fixed at; empty unless every pose and feature has an initial value.
template <int Dim>
Table<PoseIndex, Pose<Dim>> pose_vertices(const Log<Dim>& log) {
  if (log.initial.features.size() < log.features.size()) return {};
  Table<PoseIndex, Pose<Dim>> poses = log.initial.poses;
  if (poses.empty()) return poses;
  for (const FixedPose<Dim>& fixed : log.graph.fixed) poses[fixed.pose] = fixed.value;
  return poses;
}

template <int Dim>
Expected<void> check_expressible(const Log<Dim>& log, bool has_vertices) {
  const auto cannot = [](std::string message) { return tl::unexpected(Error{ErrorKind::kUsage, std::move(message)}); };
  for (const FixedPose<Dim>& fixed : log.graph.fixed) {
    if (has_vertices || local(fixed.value, Pose<Dim>{}).isZero(0.0)) continue;
    return cannot(fmt::format("g2o files cannot fix {} away from the origin without initial values of every pose and feature",
                              to_string(log.poses[fixed.pose])));
  }
  return {};
}

}  // namespace

bool is_g2o_tag(std::string_view tag) {
  return kPlane.has_tag(tag) || kSpace.has_tag(tag) || tag == kG2oFix || is_g2o_parameter(tag) || is_sensor_data(tag);
}

Expected<AnyLog> read_g2o(TextScanner text, const ReadOptions& options, Extent extent) {
  return check_conventions(text, options).and_then([&] {
    return read_edge_text(std::move(text), kPlane, &kSpace, options, extent);
  });
}

template <int Dim>
std::optional<UndeclaredName> first_undeclared_in_g2o(TextScanner text, const Declared& declared) {
  return first_undeclared(std::move(text), format<Dim>(), declared, true);
}

template <int Dim>
Expected<void> write_g2o(const Log<Dim>& log, const std::filesystem::path& path) {
  const Table<PoseIndex, Pose<Dim>> poses = pose_vertices(log);
  if (auto expressible = check_expressible(log, !poses.empty()); !expressible) return expressible;
  auto contents = contents_of<Dim>(log.source, log.poses, log.features);
  if (!poses.empty()) contents.poses = &poses;
  if (!poses.empty()) contents.features = &log.initial.features;
  for (const FixedPose<Dim>& fixed : log.graph.fixed) contents.fixed.push_back(fixed.pose);
  contents.log = &log;
  return write_edge_text(contents, format<Dim>(), path);
}

template <int Dim>
Expected<void> write_g2o(const GlobalMap<Dim>& map, const Log<Dim>* log, const std::filesystem::path& path) {
  demand_whole(map);
  if (log && (log->poses != map.pose_ids || log->features != map.feature_ids)) {
    throw std::invalid_argument("write_g2o: the log is over other poses or features than the map");
  }
  auto contents = contents_of<Dim>("", map.pose_ids, map.feature_ids);
  contents.poses = &map.poses;
  contents.features = &map.features;
  contents.fixed = map.gauge;
  contents.log = log;
  return write_edge_text(contents, format<Dim>(), path);
}

template std::optional<UndeclaredName> first_undeclared_in_g2o<2>(TextScanner, const Declared&);
template std::optional<UndeclaredName> first_undeclared_in_g2o<3>(TextScanner, const Declared&);
template Expected<void> write_g2o(const Log<2>&, const std::filesystem::path&);
template Expected<void> write_g2o(const Log<3>&, const std::filesystem::path&);
template Expected<void> write_g2o(const GlobalMap<2>&, const Log<2>*, const std::filesystem::path&);
template Expected<void> write_g2o(const GlobalMap<3>&, const Log<3>*, const std::filesystem::path&);

}  // namespace mapjoin
