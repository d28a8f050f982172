// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/picture/plotted_map.hpp>
#include <apps/truth_file.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/join/study/truth_errors.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin::apps {
namespace {

template <int Dim>
std::vector<Session> sessions_of(const Log<Dim>& log) {
  return log.odometry().empty() ? sessions_by_name(log.poses) : log.sessions;
}

template <int Dim>
Table<PoseIndex, Pose<Dim>> starts_of(const Log<Dim>& log) {
  Table<PoseIndex, Pose<Dim>> poses(log.poses.size());
  for (const auto& fixed : log.graph.fixed) poses[fixed.pose] = fixed.value;
  return poses;
}

/// The features at their first observations.
template <int Dim>
Table<FeatureIndex, Point<Dim>> first_seen(const Log<Dim>& log, const Table<PoseIndex, Pose<Dim>>& poses) {
  Table<FeatureIndex, Point<Dim>> features(log.features.size(), Point<Dim>::Zero());
  Table<FeatureIndex, bool> is_seen(features.size());
  for (const auto& o : log.observations()) {
    if (!is_seen[o.target]) features[o.target] = transform(poses[o.base], o.measured);
    is_seen[o.target] = true;
  }
  return features;
}

/// For each pose the local map that starts at or contains it, if any; the last one of a session has its end pose, too.
Table<PoseIndex, std::optional<std::size_t>> map_of_pose(const std::vector<MapFit>& fits, std::size_t poses) {
  Table<PoseIndex, std::optional<std::size_t>> map(poses);
  for (std::size_t m = fits.size(); m-- > 0;) {
    for (PoseIndex p = fits[m].base; p < fits[m].end; ++p) map[p] = m;
    if (!map[fits[m].end]) map[fits[m].end] = m;
  }
  return map;
}

/// True for a trajectory: poses with times, which are counted instead of named, and nothing that ties them.
template <int Dim>
bool is_trajectory(const PlottedMap<Dim>& plotted) {
  return !plotted.map.stamps_ns.empty() && are_counted(plotted.map.pose_ids) && !plotted.is_odometry &&
         plotted.odometry.empty() && plotted.links.empty();
}

/// The poses of a map with times.
template <int Dim>
std::vector<StampedPose> stamped_poses(const GlobalMap<Dim>& map) {
  std::vector<StampedPose> stamped;
  for (const PoseIndex p : indices(map.poses)) {
    stamped.push_back({in_seconds(map.stamps_ns[p]), in_space(map.poses[p])});
  }
  return stamped;
}

/// Turns the covariance of a step of a pose, whose translation is in the frame of the map, by `R`.
template <int Dim>
void turn(const Matrix<Dim>& R, PoseMatrix<Dim>& P) {
  P.template topRows<Dim>() = R * P.template topRows<Dim>().eval();
  P.template leftCols<Dim>() = P.template leftCols<Dim>().eval() * R.transpose();
}

}  // namespace

template <int Dim>
Table<PoseIndex, Pose<Dim>> dead_reckoning(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses) {
  for (const auto& o : log.odometry()) {
    if (o.target > o.base) {
      poses[o.target] = compose(poses[o.base], o.measured);
    } else {
      poses[o.base] = compose(poses[o.target], inverse(o.measured));
    }
  }
  return poses;
}

template <int Dim>
std::vector<PlottedLocalMap> plotted_local_maps(const std::vector<MapFit>& fits, const Log<Dim>& log) {
  std::vector<PlottedLocalMap> maps;
  for (const MapFit& fit : fits) maps.push_back({fit, {}});
  const auto map_of = map_of_pose(fits, log.poses.size());
  for (const auto& o : log.observations()) {
    if (const auto m = map_of[o.base]) maps[*m].features.push_back(o.target);
  }
  for (PlottedLocalMap& map : maps) {
    make_distinct(map.features);
  }
  return maps;
}

template <int Dim>
PlottedMap<Dim> plotted(const Log<Dim>& log) {
  PlottedMap<Dim> out;
  out.map.pose_ids = log.poses;
  out.map.feature_ids = log.features;
  out.map.stamps_ns = log.stamps_ns;
  out.map.conventions = log.conventions;
  out.sessions = sessions_of(log);
  out.is_odometry = log.initial.poses.empty();
  out.map.poses = out.is_odometry ? dead_reckoning(log, starts_of(log)) : log.initial.poses;
  const bool has_features = log.initial.features.size() == log.features.size();
  out.map.features = has_features ? log.initial.features : first_seen(log, out.map.poses);
  out.links = links_of(log.closures(), out.is_odometry ? std::span<const FeatureFactor<Dim>>() : log.observations(), out.map);
  for (Link& link : out.links) {
    if (out.is_odometry) link.residual.reset();
  }
  if (!out.is_odometry && !log.odometry().empty()) out.odometry = dead_reckoning(log, out.map.poses);
  return out;
}

template <int Dim>
PlottedMap<Dim> plotted(const RunResult<Dim>& result, const Log<Dim>& log) {
  PlottedMap<Dim> out;
  out.map = result.map;
  out.sessions = sessions_of(log);
  out.links = links_of(log.closures(), log.observations(), out.map);
  out.odometry = dead_reckoning(log, out.map.poses);
  out.local_maps = plotted_local_maps(result.maps, log);
  return out;
}

template <int Dim>
PlottedMap<Dim> plotted(const RunResult<Dim>& result, const SubmapSet<Dim>& set) {
  PlottedMap<Dim> out;
  out.map = result.map;
  out.sessions = sessions_by_name(set.poses);
  out.links = links_of<Dim>(set.graph.pose_factors, set.graph.feature_factors, out.map);
  for (std::size_t m = 0; m < result.maps.size(); ++m)
    out.local_maps.push_back({result.maps[m], set.graph.submaps[m].features});
  return out;
}

template <int Dim>
Expected<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first) {
  const auto frame = alignment_onto(truth, first);
  if (!frame) return bad_input("shares too little with the first map to be aligned with it");
  return inverse(*frame);
}

template <int Dim>
Expected<Pose<Dim>> alignment(const PlottedMap<Dim>& plotted, const PlottedMap<Dim>& onto) {
  const GlobalMap<Dim>& map = plotted.map;
  const GlobalMap<Dim>& first = onto.map;
  auto features = by_name(map.feature_ids, map.features, first.feature_ids);
  if (is_trajectory(plotted) && !first.stamps_ns.empty()) {
    return by_time<Dim>(stamped_poses(map), first.pose_ids, first.stamps_ns, kMatchingTimes).and_then([&](auto&& poses) {
      return alignment(Truth<Dim>{std::move(poses), std::move(features)}, first);
    });
  }
  if (is_trajectory(onto) && !map.stamps_ns.empty()) {
    return alignment(onto, plotted).map([](const Pose<Dim>& frame) { return inverse(frame); });
  }
  return alignment(Truth<Dim>{by_name(map.pose_ids, map.poses, first.pose_ids), std::move(features)}, first);
}

template <int Dim>
void move(const Pose<Dim>& frame, PlottedMap<Dim>& plotted) {
  const Matrix<Dim> R = frame.rotation.matrix();
  GlobalMap<Dim>& map = plotted.map;
  for (auto* poses : {&map.poses, &plotted.odometry}) {
    for (Pose<Dim>& pose : *poses) pose = compose(frame, pose);
  }
  for (Point<Dim>& feature : map.features) feature = transform(frame, feature);
  for (JoinStop<Dim>& stop : plotted.stops) stop.state = moved(frame, std::move(stop.state));
  for (PoseMatrix<Dim>& P : map.pose_covariances) turn<Dim>(R, P);
  for (PointMatrix<Dim>& P : map.feature_covariances) P = R * P.eval() * R.transpose();
}

template <int Dim>
void move(const Pose<Dim>& frame, Truth<Dim>& truth) {
  for (auto& pose : truth.poses) {
    if (pose) pose = compose(frame, *pose);
  }
  for (auto& feature : truth.features) {
    if (feature) feature = transform(frame, *feature);
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                         \
  template Table<PoseIndex, Pose<Dim>> dead_reckoning(const Log<Dim>&, Table<PoseIndex, Pose<Dim>>);     \
  template std::vector<PlottedLocalMap> plotted_local_maps(const std::vector<MapFit>&, const Log<Dim>&); \
  template Expected<Pose<Dim>> alignment(const PlottedMap<Dim>&, const PlottedMap<Dim>&);                \
  template Expected<Pose<Dim>> alignment(const Truth<Dim>&, const GlobalMap<Dim>&);                      \
  template void move(const Pose<Dim>&, PlottedMap<Dim>&);                                                \
  template void move(const Pose<Dim>&, Truth<Dim>&);                                                     \
  template PlottedMap<Dim> plotted(const Log<Dim>&);                                                     \
  template PlottedMap<Dim> plotted(const RunResult<Dim>&, const Log<Dim>&);                              \
  template PlottedMap<Dim> plotted(const RunResult<Dim>&, const SubmapSet<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
