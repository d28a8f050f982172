// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/markup.hpp>
#include <apps/picture/plotted_map.hpp>

namespace mapjoin::apps {
namespace {

constexpr const char* kGrey = "#b0b0b0";
constexpr const char* kSlate = "#8a94a6";
constexpr const char* kInk = "#1c2024";
constexpr const char* kBlue = kDistinctColours[0];
constexpr const char* kOrange = kDistinctColours[1];

constexpr double kSigmas = 3.0;
constexpr std::size_t kPoseEllipses = 50;  // about so many along a trajectory without local maps

/// In their order, without the features' colour.
std::vector<std::string> local_map_colours() {
  return {kDistinctColours[0], kDistinctColours[2], kDistinctColours[3], kDistinctColours[5], kDistinctColours[4]};
}

template <int Dim>
Point<2> place(const PlottedMap<Dim>& plotted, PoseIndex pose) {
  return plotted.map.poses[pose].translation.template head<2>();
}

template <int Dim>
std::vector<FlatLine> closure_lines(const PlottedMap<Dim>& plotted) {
  std::vector<FlatLine> lines;
  for (const auto& [base, target] : plotted.closures) lines.push_back({place(plotted, base), place(plotted, target)});
  return lines;
}

template <int Dim>
std::vector<FlatLine> local_map_lines(const PlottedMap<Dim>& plotted) {
  std::vector<Session> parts;
  for (const PlottedLocalMap& map : plotted.local_maps) parts.push_back({map.fit.base, map.fit.end + 1});
  return trajectory_lines(plotted.map.poses, parts);
}

/// The last poses of the local maps.
template <int Dim>
std::vector<PoseIndex> end_poses(const PlottedMap<Dim>& plotted) {
  std::vector<PoseIndex> poses;
  for (const PlottedLocalMap& map : plotted.local_maps) poses.push_back(map.fit.end);
  return poses;
}

template <int Dim, typename Covariance>
Ellipse ellipse_at(const Point<2>& place, const Covariance& P) {
  return ellipse(place, P.template topLeftCorner<2, 2>(), kSigmas);
}

/// Where local maps end, or else of some poses evenly among all.
template <int Dim>
std::vector<Ellipse> pose_ellipses(const PlottedMap<Dim>& plotted) {
  std::vector<PoseIndex> marked = end_poses(plotted);
  const std::size_t every = 1 + plotted.map.poses.size() / kPoseEllipses;
  for (std::size_t p = every; plotted.local_maps.empty() && p <= plotted.map.poses.size(); p += every) {
    marked.emplace_back(p - 1);
  }
  std::vector<Ellipse> ellipses;
  for (const PoseIndex pose : marked) {
    if (plotted.map.pose_covariances.empty()) break;
    ellipses.push_back(ellipse_at<Dim>(place(plotted, pose), plotted.map.pose_covariances[pose]));
  }
  return ellipses;
}

template <int Dim>
std::vector<Ellipse> feature_ellipses(const GlobalMap<Dim>& map) {
  std::vector<Ellipse> ellipses;
  for (const FeatureIndex f : indices(map.feature_covariances)) {
    ellipses.push_back(ellipse_at<Dim>(map.features[f].template head<2>(), map.feature_covariances[f]));
  }
  return ellipses;
}

template <int Dim>
void add_single(const PlottedMap<Dim>& plotted, std::vector<Layer>& layers) {
  const GlobalMap<Dim>& map = plotted.map;
  const auto add = [&](Layer layer) {
    if (!layer.lines.empty() || !layer.marks.empty() || !layer.ellipses.empty()) layers.push_back(std::move(layer));
  };
  if (!plotted.odometry.empty()) {
    add({"odometry alone", {kGrey}, trajectory_lines(plotted.odometry, plotted.sessions), {}, {}, 1.0, {}, false, false});
  }
  add({"loop closures", {kSlate}, closure_lines(plotted), {}, {}, 0.5});
  add({"3σ of features", {kOrange}, {}, {}, feature_ellipses(map), 0.6});
  add({"features", {kOrange}, {}, from_above(map.features), {}});
  add({"3σ of poses", {kInk}, {}, {}, pose_ellipses(plotted), 0.6});
  const std::string name = plotted.is_odometry ? "odometry alone" : "trajectory";
  add({plotted.local_maps.empty() ? name : "", {kBlue}, trajectory_lines(map.poses, plotted.sessions), {}, {}});
  add({"local maps", local_map_colours(), local_map_lines(plotted), {}, {}, 2.0});
  std::vector<Point<2>> ends;
  for (const PoseIndex pose : end_poses(plotted)) ends.push_back(place(plotted, pose));
  add({"end poses", {kInk}, {}, std::move(ends), {}, 1.0, Mark::kSpeck});
}

template <int Dim>
Layer in_one_colour(const PlottedMap<Dim>& plotted, const std::string& colour) {
  return {plotted.name,
          {colour},
          trajectory_lines(plotted.map.poses, plotted.sessions),
          from_above(plotted.map.features),
          feature_ellipses(plotted.map),
          1.2};
}

/// Broken where a pose is not known.
template <int Dim>
std::vector<FlatLine> known_lines(const Truth<Dim>& truth, const std::vector<Session>& sessions) {
  std::vector<FlatLine> lines;
  for (const Session& session : sessions) {
    FlatLine line;
    for (PoseIndex p = session.begin; p < session.end; ++p) {
      const auto& pose = truth.poses[p];
      if (pose) line.push_back(pose->translation.template head<2>());
      if (!pose && !line.empty()) lines.push_back(std::exchange(line, {}));
    }
    if (!line.empty()) lines.push_back(std::move(line));
  }
  return lines;
}

template <int Dim>
Layer truth_layer(const Truth<Dim>& truth, const std::vector<Session>& sessions) {
  Layer layer{"truth", {kInk}, known_lines(truth, sessions), {}, {}, 0.9, Mark::kRing, true};
  for (const auto& feature : truth.features) {
    if (feature) layer.marks.push_back(feature->template head<2>());
  }
  return layer;
}

}  // namespace

template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth) {
  std::vector<Layer> layers;
  if (maps.size() == 1) add_single(maps.front(), layers);
  // The first one on top.
  for (std::size_t m = maps.size(); m-- > 0 && maps.size() > 1;) {
    layers.push_back(in_one_colour(maps[m], kDistinctColours[m % kDistinctColours.size()]));
  }
  if (truth) layers.push_back(truth_layer(*truth, maps.front().sessions));
  return layers;
}

template std::vector<Layer> map_layers(const std::vector<PlottedMap<2>>&, const Truth<2>*);
template std::vector<Layer> map_layers(const std::vector<PlottedMap<3>>&, const Truth<3>*);

}  // namespace mapjoin::apps
