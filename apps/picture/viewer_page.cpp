// SPDX-License-Identifier: BSD-3-Clause
// The scene is JSON whose numbers are base64 of little-endian arrays; positions are 32-bit floats about the middle of the first
// map, which is given in full: they then tell a micrometre at ten metres.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <apps/picture/markup.hpp>
#include <apps/picture/plotted_map.hpp>
#include <apps/position.hpp>
#include <apps/report/json.hpp>
#include <array>
#include <boost/algorithm/string/replace.hpp>
#include <cstdint>
#include <functional>
#include <limits>
#include <mapjoin/geometry/upper_triangle.hpp>

namespace mapjoin::apps {

// Embedded by cmake/embed.cmake, from viewer/ and from Debian's libjs-three.
namespace embedded {
extern const std::string_view viewer_style;
extern const std::string_view viewer_body;
extern const std::string_view viewer_scripts;
}  // namespace embedded

namespace {

/// The numbers in a list, or a numeric member of its items, as base64.
template <typename Number, typename List, typename Member = std::identity>
std::string packed(const List& list, Member member = {}) {
  std::vector<Number> numbers;
  for (const auto& one : list) numbers.push_back(static_cast<Number>(std::invoke(member, one)));
  return base64(numbers);
}

/// Three numbers per pose or point, about `centre`, with z = 0 in the plane; NaN if unknown.
template <int Dim, typename List>
std::string places_of(const List& list, const Point<Dim>& centre) {
  std::vector<float> numbers;
  for (const auto& one : list) {
    Point<3> place = Point<3>::Constant(std::numeric_limits<double>::quiet_NaN());
    if (const auto* known = position_of(one)) {
      place.setZero();
      place.template head<Dim>() = *known - centre;
    }
    for (const double coordinate : place) numbers.push_back(static_cast<float>(coordinate));
  }
  return base64(numbers);
}

/// The session of each pose; empty if all are of session 0.
std::string robots_of(const std::vector<PoseId>& ids) {
  const bool is_one = std::all_of(ids.begin(), ids.end(), [](const PoseId& id) { return id.session == 0; });
  return is_one ? "" : packed<std::uint32_t>(ids, &PoseId::session);
}

/// Headings in the plane; empty in space.
template <int Dim>
std::string headings_of(const std::vector<Pose<Dim>>& poses) {
  if constexpr (Dim == 3) return "";
  if constexpr (Dim == 2) return packed<float>(poses, [](const auto& pose) { return wrap_angle(pose.rotation.angle()); });
}

/// Upper triangles of covariances, row by row.
template <typename Covariance>
std::string triangles_of(const std::vector<Covariance>& covariances) {
  std::vector<double> entries;
  for (const Covariance& P : covariances) {
    each_of_upper_triangle(P, [&](double entry) { entries.push_back(entry); });
  }
  return packed<float>(entries);
}

/// The local maps as JSON: their features stand in one list, and offsets say where each map's begin.
Json local_maps_of(const std::vector<PlottedLocalMap>& maps) {
  std::vector<FeatureIndex> features;
  std::vector<MapFit> fits;
  std::vector<std::size_t> offsets = {0};
  for (const PlottedLocalMap& map : maps) {
    fits.push_back(map.fit);
    features.insert(features.end(), map.features.begin(), map.features.end());
    offsets.push_back(features.size());
  }
  return {{"count", maps.size()},
          {"base", packed<std::uint32_t>(fits, [](const MapFit& fit) { return fit.base.value; })},
          {"end", packed<std::uint32_t>(fits, [](const MapFit& fit) { return fit.end.value; })},
          {"chi2", packed<double>(fits, &MapFit::chi2)},
          {"rows", packed<std::uint32_t>(fits, &MapFit::rows)},
          {"probability", packed<double>(fits, &MapFit::probability)},
          {"offsets", packed<std::uint32_t>(offsets)},
          {"features", packed<std::uint32_t>(features, &FeatureIndex::value)}};
}

template <int Dim>
Json stops_of(const std::vector<JoinStop<Dim>>& stops, const Point<Dim>& centre) {
  Json list = Json::array();
  for (const JoinStop<Dim>& stop : stops) {
    list.push_back({{"maps", stop.maps},
                    {"chi2", stop.chi2},
                    {"poses", packed<std::uint32_t>(stop.poses, &PoseIndex::value)},
                    {"posePlaces", places_of(stop.state.poses, centre)},
                    {"featurePlaces", places_of(stop.state.features, centre)}});
  }
  return list;
}

/// The classes that have links: their style, and the ends of each link, with features counted on from the poses.
template <int Dim>
Json links_of(const PlottedMap<Dim>& plotted) {
  std::array<std::vector<std::size_t>, kLinkClasses.size()> ends;
  for (const Link& link : plotted.links) {
    const auto* pose = std::get_if<PoseIndex>(&link.to);
    const std::size_t to = pose ? pose->position() : plotted.map.poses.size() + std::get<FeatureIndex>(link.to).position();
    ends[class_of(link)].insert(ends[class_of(link)].end(), {link.from.position(), to});
  }
  Json list = Json::array();
  for (std::size_t c = 0; c < ends.size(); ++c) {
    const LinkClass& of = kLinkClasses[c];
    if (ends[c].empty()) continue;
    list.push_back({{"name", of.name},
                    {"colours", {{"light", of.on_light}, {"dark", of.on_dark}}},
                    {"width", of.width},
                    {"isDashed", of.is_dashed},
                    {"isOnTop", of.is_on_top},
                    {"ends", packed<std::uint32_t>(ends[c])}});
  }
  return list;
}

std::string packed_sessions(const std::vector<Session>& sessions) {
  std::vector<PoseIndex> ends;
  for (const auto& [begin, end] : sessions) ends.insert(ends.end(), {begin, end});
  return packed<std::uint32_t>(ends, &PoseIndex::value);
}

template <int Dim>
Json trajectories_json(const PlottedMap<Dim>& plotted) {
  Json list = Json::array();
  for (const Trajectory& of : trajectories_of(plotted)) {
    list.push_back({{"name", of.name}, {"colour", of.colour}, {"sessions", packed_sessions(of.sessions)}});
  }
  return list;
}

template <int Dim>
Json map_of(const PlottedMap<Dim>& plotted, const Point<Dim>& centre) {
  const GlobalMap<Dim>& map = plotted.map;
  const EllipseCap cap = ellipse_cap(map);
  return {{"name", plotted.name},
          {"isOdometry", plotted.is_odometry},
          {"poses", places_of(map.poses, centre)},
          {"headings", headings_of(map.poses)},
          {"poseKeys", packed<std::uint64_t>(map.pose_ids, &PoseId::key)},
          {"robots", robots_of(map.pose_ids)},
          {"sessions", packed_sessions(plotted.sessions)},
          {"trajectories", trajectories_json(plotted)},
          {"poseCovariances", triangles_of(map.pose_covariances)},
          {"features", places_of(map.features, centre)},
          {"featureKeys", packed<std::uint64_t>(map.feature_ids, &FeatureId::key)},
          {"featureCovariances", triangles_of(map.feature_covariances)},
          {"odometry", places_of(plotted.odometry, centre)},
          {"links", links_of(plotted)},
          {"ellipses",
           {{"cap", cap.half_axis},
            {"ofPoses", name_of_ellipses("poses", cap.poses)},
            {"ofFeatures", name_of_ellipses("features", cap.features)}}},
          {"localMaps", local_maps_of(plotted.local_maps)},
          {"stops", stops_of(plotted.stops, centre)}};
}

/// The scene as JSON without a `<`, so that it can stand in a script element.
template <int Dim>
std::string scene_json(const Scene<Dim>& scene, const std::string& title) {
  Eigen::AlignedBox<double, Dim> box;
  for (const Pose<Dim>& pose : scene.maps.front().map.poses) box.extend(pose.translation);
  if (box.isEmpty()) box.extend(Point<Dim>::Zero().eval());
  const Point<Dim> centre = box.center();
  Json json = {{"title", title},
               {"dimension", Dim},
               {"centre", std::vector<double>(centre.begin(), centre.end())},
               {"maps", Json::array()},
               {"truth", nullptr}};
  for (const auto& plotted : scene.maps) json["maps"].push_back(map_of(plotted, centre));
  if (scene.truth) {
    json["truth"] = {{"poses", places_of(scene.truth->poses, centre)}, {"features", places_of(scene.truth->features, centre)}};
  }
  return boost::replace_all_copy(json.dump(-1, ' ', false, Json::error_handler_t::replace), "<", "\\u003c");
}

}  // namespace

template <int Dim>
std::string viewer_page(const Scene<Dim>& scene, const std::string& title) {
  return html_page(title, embedded::viewer_style,
                   fmt::format("{}<script type=\"application/json\" id=\"scene\">{}</script>\n{}", embedded::viewer_body,
                               scene_json(scene, title), embedded::viewer_scripts));
}

template std::string viewer_page(const Scene<2>&, const std::string&);
template std::string viewer_page(const Scene<3>&, const std::string&);

}  // namespace mapjoin::apps
