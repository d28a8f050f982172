// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/markup.hpp>
#include <apps/picture/plotted_map.hpp>
#include <array>

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
const std::vector<std::string> kLocalMapColours = {kDistinctColours[0], kDistinctColours[2], kDistinctColours[3],
                                                   kDistinctColours[5], kDistinctColours[4]};

/// Of a pose or a feature.
template <typename Place, typename Covariance>
Ellipse ellipse_at(const Place& place, const Covariance& P) {
  return ellipse(place_of(place)->template head<2>(), P.template topLeftCorner<2, 2>(), kSigmas);
}

/// Where local maps end, or else of some poses evenly among all.
template <int Dim>
std::vector<Ellipse> pose_ellipses(const PlottedMap<Dim>& plotted) {
  std::vector<Ellipse> ellipses;
  const GlobalMap<Dim>& map = plotted.map;
  if (map.pose_covariances.empty()) return ellipses;
  const auto add = [&](PoseIndex pose) { ellipses.push_back(ellipse_at(map.poses[pose], map.pose_covariances[pose])); };
  for (const PlottedLocalMap& local : plotted.local_maps) add(local.fit.end);
  const std::size_t every = 1 + map.poses.size() / kPoseEllipses;
  for (std::size_t p = every; plotted.local_maps.empty() && p <= map.poses.size(); p += every) add(PoseIndex(p - 1));
  return ellipses;
}

template <int Dim>
std::vector<Ellipse> feature_ellipses(const GlobalMap<Dim>& map) {
  std::vector<Ellipse> ellipses;
  for (const FeatureIndex f : indices(map.feature_covariances)) {
    ellipses.push_back(ellipse_at(map.features[f], map.feature_covariances[f]));
  }
  return ellipses;
}

template <int Dim>
void add_single(const PlottedMap<Dim>& plotted, std::vector<Layer>& layers) {
  const GlobalMap<Dim>& map = plotted.map;
  const auto add = [&](Layer layer) {
    if (!layer.lines.empty() || !layer.marks.empty() || !layer.ellipses.empty()) layers.push_back(std::move(layer));
  };
  std::vector<FlatLine> closures;
  for (const auto& [base, target] : plotted.closures) {
    closures.push_back(from_above(std::array{map.poses[base], map.poses[target]}));
  }
  std::vector<Session> local_maps;
  std::vector<Pose<Dim>> ends;
  for (const PlottedLocalMap& local : plotted.local_maps) {
    local_maps.push_back({local.fit.base, local.fit.end + 1});
    ends.push_back(map.poses[local.fit.end]);
  }
  if (!plotted.odometry.empty()) {
    add({"odometry alone", {kGrey}, trajectory_lines(plotted.odometry, plotted.sessions), {}, {}, 1.0, {}, false, false});
  }
  add({"loop closures", {kSlate}, std::move(closures), {}, {}, 0.5});
  add({"3σ of features", {kOrange}, {}, {}, feature_ellipses(map), 0.6});
  add({"features", {kOrange}, {}, from_above(map.features), {}});
  add({"3σ of poses", {kInk}, {}, {}, pose_ellipses(plotted), 0.6});
  const std::string name = plotted.is_odometry ? "odometry alone" : "trajectory";
  add({local_maps.empty() ? name : "", {kBlue}, trajectory_lines(map.poses, plotted.sessions), {}, {}});
  add({"local maps", kLocalMapColours, trajectory_lines(map.poses, local_maps), {}, {}, 2.0});
  add({"end poses", {kInk}, {}, from_above(ends), {}, 1.0, Mark::kSpeck});
}

}  // namespace

template <int Dim>
std::vector<Layer> map_layers(const std::vector<PlottedMap<Dim>>& maps, const Truth<Dim>* truth) {
  std::vector<Layer> layers;
  if (maps.size() == 1) add_single(maps.front(), layers);
  // The first one on top.
  for (std::size_t m = maps.size(); m-- > 0 && maps.size() > 1;) {
    const GlobalMap<Dim>& map = maps[m].map;
    layers.push_back({maps[m].name,
                      {kDistinctColours[m % kDistinctColours.size()]},
                      trajectory_lines(map.poses, maps[m].sessions),
                      from_above(map.features),
                      feature_ellipses(map),
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

template std::vector<Layer> map_layers(const std::vector<PlottedMap<2>>&, const Truth<2>*);
template std::vector<Layer> map_layers(const std::vector<PlottedMap<3>>&, const Truth<3>*);

}  // namespace mapjoin::apps
