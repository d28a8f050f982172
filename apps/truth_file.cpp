// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/outputs.hpp>
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

/// The poses of a map, by the names that a trajectory has for them: their time stamps to the microsecond,
/// or, where the map has none, their count.
template <int Dim>
std::map<std::int64_t, PoseIndex> places_of(const GlobalMap<Dim>& map) {
  std::map<std::int64_t, PoseIndex> at;
  for (const PoseIndex p : indices(map.poses)) {
    at.emplace(map.stamps_ns.empty() ? p.value : map.stamps_ns[p] / 1000, p);
  }
  return at;
}

/// A time was read as a floating-point number: it may be off by a microsecond.
template <int Dim>
Truth<Dim> by_time(const std::vector<StampedPose>& trajectory, const GlobalMap<Dim>& map) {
  const auto at = places_of(map);
  Truth<Dim> truth;
  truth.poses.resize(map.poses.size());
  truth.features.resize(map.features.size());
  for (const StampedPose& line : trajectory) {
    const bool is_count = map.stamps_ns.empty();
    const auto time = is_count ? static_cast<std::int64_t>(std::floor(line.time)) : std::llround(1e6 * line.time);
    for (const std::int64_t off : {-1, 1, 0}) {
      const auto found = at.find(is_count ? time : time + off);
      if (found != at.end()) truth.poses[found->second] = in_dimension(line.pose, std::integral_constant<int, Dim>());
    }
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
    return by_time(*trajectory, map);
  }
  if (const auto* log = std::get_if<Log<Dim>>(&std::get<AnyLog>(content_))) {
    return Truth<Dim>{by_name(log->poses, log->initial.poses, map.pose_ids),
                      by_name(log->features, log->initial.features, map.feature_ids)};
  }
  return tl::unexpected(Error{ErrorKind::kUsage, fmt::format("{}: the truth is not in {}D, as the map is", path_, Dim)});
}

template Expected<Truth<2>> TruthFile::of(const GlobalMap<2>&) const;
template Expected<Truth<3>> TruthFile::of(const GlobalMap<3>&) const;

}  // namespace mapjoin::apps
