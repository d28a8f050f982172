// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/map_file.hpp>
#include <apps/truth_file.hpp>
#include <cmath>
#include <map>
#include <mapjoin/io/open.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

const Pose<3>& in_dimension(const Pose<3>& pose, std::integral_constant<int, 3>) {
  return pose;
}
/// The turn about z of a pose in the plane.
Pose<2> in_dimension(const Pose<3>& pose, std::integral_constant<int, 2>) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  return {pose.translation.head<2>(), Rotation<2>(2.0 * std::atan2(q.z(), q.w()))};
}

std::int64_t microseconds(std::int64_t nanoseconds) {
  return nanoseconds / 1000;
}

template <int Dim>
Truth<Dim> nothing_of(const GlobalMap<Dim>& map) {
  Truth<Dim> truth;
  truth.poses.resize(map.poses.size());
  truth.features.resize(map.features.size());
  return truth;
}

template <int Dim>
Truth<Dim> by_name(const Log<Dim>& log, const GlobalMap<Dim>& map) {
  std::map<PoseId, Pose<Dim>> poses;
  std::map<FeatureId, Point<Dim>> features;
  for (std::size_t p = 0; p < log.initial.poses.size(); ++p) poses.emplace(log.poses[p], log.initial.poses[p]);
  for (std::size_t f = 0; f < log.initial.features.size(); ++f) features.emplace(log.features[f], log.initial.features[f]);
  Truth<Dim> truth = nothing_of(map);
  for (std::size_t p = 0; p < map.poses.size(); ++p) {
    if (const auto found = poses.find(map.pose_ids[p]); found != poses.end()) truth.poses[p] = found->second;
  }
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    if (const auto found = features.find(map.feature_ids[f]); found != features.end()) truth.features[f] = found->second;
  }
  return truth;
}

/// The time of a line, and those beside it: it was read as a floating-point number.
template <int Dim>
Truth<Dim> by_time(const std::vector<StampedPose>& trajectory, const GlobalMap<Dim>& map) {
  std::map<std::int64_t, std::size_t> at;
  for (std::size_t p = 0; p < map.stamps_ns.size(); ++p) at.emplace(microseconds(map.stamps_ns[p]), p);
  Truth<Dim> truth = nothing_of(map);
  for (const StampedPose& line : trajectory) {
    const std::int64_t time = std::llround(1e6 * line.time);
    for (const std::int64_t beside : {time - 1, time + 1, time}) {
      const auto found = at.find(beside);
      if (found != at.end()) truth.poses[found->second] = in_dimension(line.pose, std::integral_constant<int, Dim>());
    }
  }
  return truth;
}

template <int Dim>
Truth<Dim> by_count(const std::vector<StampedPose>& trajectory, const GlobalMap<Dim>& map) {
  Truth<Dim> truth = nothing_of(map);
  for (const StampedPose& line : trajectory) {
    if (line.time < 0.0 || line.time >= static_cast<double>(map.poses.size())) continue;
    const auto count = static_cast<std::size_t>(line.time);
    truth.poses[count] = in_dimension(line.pose, std::integral_constant<int, Dim>());
  }
  return truth;
}

}  // namespace

Expected<TruthFile> TruthFile::open(const std::filesystem::path& path) {
  if (extension_of(path) == ".tum") {
    return read_tum(path).map([&](auto&& trajectory) { return TruthFile(path.string(), Content(std::move(trajectory))); });
  }
  auto log = open_log(path);
  if (!log) return tl::unexpected(log.error());
  const bool has_values = std::visit([](const auto& any) { return !any.initial.poses.empty(); }, *log);
  if (!has_values) return bad_input(path.string() + ": as a truth it would have to give the values of its poses");
  return TruthFile(path.string(), Content(*std::move(log)));
}

template <int Dim>
Expected<Truth<Dim>> TruthFile::of(const GlobalMap<Dim>& map) const {
  if (const auto* trajectory = std::get_if<std::vector<StampedPose>>(&content_)) {
    return map.stamps_ns.empty() ? by_count(*trajectory, map) : by_time(*trajectory, map);
  }
  const auto* log = std::get_if<Log<Dim>>(&std::get<AnyLog>(content_));
  if (log) return by_name(*log, map);
  return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: the truth is not in {}D, as the map is", path_, Dim)});
}

template Expected<Truth<2>> TruthFile::of(const GlobalMap<2>&) const;
template Expected<Truth<3>> TruthFile::of(const GlobalMap<3>&) const;

}  // namespace mapjoin::apps
