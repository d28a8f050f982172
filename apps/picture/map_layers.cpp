// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <apps/certainty.hpp>
#include <apps/picture/markup.hpp>
#include <apps/picture/plotted_map.hpp>
#include <apps/position.hpp>
#include <array>
#include <cmath>

namespace mapjoin::apps {
namespace {

constexpr const char* kGrey = "#b0b0b0";
constexpr const char* kInk = "#1c2024";
constexpr const char* kOrange = kDistinctColours[1];

constexpr double kSigmas = 3.0;
constexpr double kManyLinks = 200.0;       // links of one class: more are drawn finer
constexpr std::size_t kPoseEllipses = 50;  // about so many ellipses along a trajectory without local maps

/// The colours of local maps and sessions, in their order, without that of features.
const std::vector<std::string> kPathColours = {kDistinctColours[0], kDistinctColours[2], kDistinctColours[3],
                                               kDistinctColours[5], kDistinctColours[4]};

/// The ellipse of a pose or a feature, capped.
template <typename Place, typename Covariance>
Ellipse ellipse_at(const Place& place, const Covariance& P, const EllipseCap& cap) {
  Ellipse e = ellipse(position_of(place)->template head<2>(), P.template topLeftCorner<2, 2>(), kSigmas);
  e.half_axes = e.half_axes.cwiseMin(cap.half_axis);
  return e;
}

/// The number of covariances whose ellipse, or ellipsoid, has a half axis longer than this.
template <int Dim, typename Covariances>
std::size_t count_larger(const Covariances& covariances, double half_axis) {
  return static_cast<std::size_t>(std::ranges::count_if(covariances, [&](const auto& P) {
    const Matrix<Dim> of_position = P.template topLeftCorner<Dim, Dim>();
    return kSigmas * std::sqrt(of_position.template selfadjointView<Eigen::Lower>().operatorNorm()) > half_axis;
  }));
}

/// The ellipses of the poses where local maps end or, without local maps, of some poses evenly among all.
template <int Dim>
std::vector<Ellipse> pose_ellipses(const PlottedMap<Dim>& plotted, const EllipseCap& cap) {
  std::vector<Ellipse> ellipses;
  const GlobalMap<Dim>& map = plotted.map;
  if (map.pose_covariances.empty()) return ellipses;
  const auto add = [&](PoseIndex pose) { ellipses.push_back(ellipse_at(map.poses[pose], map.pose_covariances[pose], cap)); };
  for (const PlottedLocalMap& local : plotted.local_maps) add(local.fit.end);
  const std::size_t every = 1 + map.poses.size() / kPoseEllipses;
  for (std::size_t p = every; plotted.local_maps.empty() && p <= map.poses.size(); p += every) add(PoseIndex(p - 1));
  return ellipses;
}

template <int Dim>
std::vector<Ellipse> feature_ellipses(const GlobalMap<Dim>& map, const EllipseCap& cap) {
  std::vector<Ellipse> ellipses;
  for (const FeatureIndex f : indices(map.feature_covariances)) {
    ellipses.push_back(ellipse_at(map.features[f], map.feature_covariances[f], cap));
  }
  return ellipses;
}

/// One layer for each class of links, the finer the more lines it has.
template <int Dim>
std::vector<Layer> link_layers(const PlottedMap<Dim>& plotted) {
  const GlobalMap<Dim>& map = plotted.map;
  std::vector<Layer> layers;
  for (const LinkClass& of : kLinkClasses)
    layers.push_back({of.name, {of.on_light}, {}, {}, {}, of.width, Mark::kDot, of.is_dashed});
  for (const Link& link : plotted.links) {
    const auto* pose = std::get_if<PoseIndex>(&link.to);
    const Point<Dim>& to = pose ? map.poses[*pose].translation : map.features[std::get<FeatureIndex>(link.to)];
    layers[class_of(link)].lines.push_back(from_above(std::array{map.poses[link.from].translation, to}));
  }
  for (Layer& layer : layers) layer.width *= std::clamp(kManyLinks / static_cast<double>(layer.lines.size()), 0.3, 1.0);
  return layers;
}

template <int Dim>
void add_single(const PlottedMap<Dim>& plotted, std::vector<Layer>& layers) {
  const GlobalMap<Dim>& map = plotted.map;
  const EllipseCap cap = ellipse_cap(map);
  const std::vector<Trajectory> trajectories = trajectories_of(plotted);
  const auto add = [&](Layer layer) {
    if (!layer.lines.empty() || !layer.marks.empty() || !layer.ellipses.empty()) layers.push_back(std::move(layer));
  };
  const std::vector<Layer> links = link_layers(plotted);
  const auto add_links = [&](bool is_on_top) {
    for (std::size_t c = 0; c < links.size(); ++c) {
      if (kLinkClasses[c].is_on_top == is_on_top) add(links[c]);
    }
  };
  std::vector<Session> local_maps;
  std::vector<Pose<Dim>> ends;
  for (const PlottedLocalMap& local : plotted.local_maps) {
    local_maps.push_back({local.fit.base, local.fit.end + 1});
    ends.push_back(map.poses[local.fit.end]);
  }
  if (!plotted.odometry.empty()) {
    add({"odometry alone", {kGrey}, trajectory_lines(plotted.odometry, plotted.sessions), {}, {}, 1.0, {}, false, false});
  }
  add_links(false);
  add({name_of_ellipses("features", cap.features), {kOrange}, {}, {}, feature_ellipses(map, cap), 0.6});
  add({"features", {kOrange}, {}, from_above(map.features), {}});
  add({name_of_ellipses("poses", cap.poses), {kInk}, {}, {}, pose_ellipses(plotted, cap), 0.6});
  const bool is_of_maps = trajectories.size() == 1 && !local_maps.empty();
  for (auto of = trajectories.rbegin(); of != trajectories.rend(); ++of) {
    add({is_of_maps ? "" : of->name, {of->colour}, trajectory_lines(map.poses, of->sessions), {}, {}});
  }
  if (is_of_maps) {
    add({"local maps", kPathColours, trajectory_lines(map.poses, local_maps), {}, {}, 2.0});
    add({"end poses", {kInk}, {}, from_above(ends), {}, 1.0, Mark::kSpeck});
  }
  add_links(true);
}

/// The name of a session: by its robot if there are several, otherwise by its poses.
std::string name_of(const Session& session, const PoseIds& ids, bool has_robots) {
  const PoseId& first = ids[session.begin];
  return has_robots ? fmt::format("session {}", first.session)
                    : fmt::format("poses {} to {}", key_text(first.key), key_text(ids[session.end - 1].key));
}

}  // namespace

template <int Dim>
std::vector<Trajectory> trajectories_of(const PlottedMap<Dim>& plotted) {
  const PoseIds& ids = plotted.map.pose_ids;
  const std::vector<Session>& sessions = plotted.sessions;
  const auto robot_of = [&](const Session& session) { return ids[session.begin].session; };
  const bool has_robots = !sessions.empty() && robot_of(sessions.front()) != robot_of(sessions.back());
  std::vector<Trajectory> trajectories;
  std::size_t parts = 0;
  for (std::size_t s = 0; s < sessions.size(); ++s) {
    if (s == 0 || !has_robots || robot_of(sessions[s]) != robot_of(sessions[s - 1])) ++parts;
    const std::size_t k = (parts - 1) % kPathColours.size();
    if (k == trajectories.size()) trajectories.push_back({name_of(sessions[s], ids, has_robots), kPathColours[k], {}});
    trajectories[k].sessions.push_back(sessions[s]);
  }
  if (parts == 1) trajectories.front().name = plotted.is_odometry ? "odometry alone" : "trajectory";
  for (std::size_t k = 0; k + kPathColours.size() < parts && k < trajectories.size(); ++k)
    trajectories[k].name += " and others";
  return trajectories;
}

std::string name_of_ellipses(const std::string& things, std::size_t capped) {
  return "3σ of " + things + (capped == 0 ? "" : " (capped at the map's size)");
}

std::string EllipseCap::in_words() const {
  if (poses + features == 0) return "";
  return fmt::format("the 3σ ellipses of {} and {} are larger than the map, and are capped at its size", plural(poses, "pose"),
                     plural(features, "feature"));
}

template <int Dim>
EllipseCap ellipse_cap(const GlobalMap<Dim>& map) {
  const double half = 0.5 * extent_of(map);
  return {half, count_larger<Dim>(map.pose_covariances, half), count_larger<Dim>(map.feature_covariances, half)};
}

template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth) {
  std::vector<Layer> layers;
  if (maps.size() == 1) add_single(maps.front(), layers);
  // The first map is on top.
  for (std::size_t m = maps.size(); m-- > 0 && maps.size() > 1;) {
    const GlobalMap<Dim>& map = maps[m].map;
    layers.push_back({maps[m].name,
                      {kDistinctColours[m % kDistinctColours.size()]},
                      trajectory_lines(map.poses, maps[m].sessions),
                      from_above(map.features),
                      feature_ellipses(map, ellipse_cap(map)),
                      1.2});
  }
  if (truth) {
    layers.push_back({"truth",
                      {kInk},
                      trajectory_lines(truth->poses, maps.front().sessions),
                      from_above(truth->features),
                      {},
                      0.9,
                      Mark::kRing,
                      true});
  }
  return layers;
}

#define MAPJOIN_INSTANTIATE(Dim)                                            \
  template std::vector<Trajectory> trajectories_of(const PlottedMap<Dim>&); \
  template EllipseCap ellipse_cap(const GlobalMap<Dim>&);                   \
  template std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>&, const Truth<Dim>*);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
