// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/exit_code.hpp>
#include <apps/outputs.hpp>
#include <apps/truth_file.hpp>
#include <cmath>
#include <map>
#include <mapjoin/io/open.hpp>

namespace mapjoin::apps {
namespace {

/// Of a pose in the plane, the turn about z.
template <int Dim>
Pose<Dim> in_dimension(const Pose<3>& pose) {
  if constexpr (Dim == 3) {
    return pose;
  } else {
    const Eigen::Quaterniond& q = pose.rotation.quaternion();
    return {pose.translation.head<2>(), Rotation<2>(2.0 * std::atan2(q.z(), q.w()))};
  }
}

/// The poses by the names that a trajectory has for them: their time stamps to the microsecond, or, where there are none, their
/// count. A time was read as a floating-point number: it may be off by a microsecond.
template <int Dim>
Table<PoseIndex, std::optional<Pose<Dim>>> by_time(const std::vector<StampedPose>& trajectory, std::size_t poses,
                                                   const Table<PoseIndex, std::int64_t>& stamps_ns) {
  const bool is_count = stamps_ns.empty();
  Table<PoseIndex, std::optional<Pose<Dim>>> found(poses);
  std::map<std::int64_t, PoseIndex> at;
  for (const PoseIndex p : indices(found)) at.emplace(is_count ? p.value : stamps_ns[p] / 1000, p);
  for (const StampedPose& line : trajectory) {
    const auto time = is_count ? static_cast<std::int64_t>(std::floor(line.time)) : std::llround(1e6 * line.time);
    for (const std::int64_t off : {-1, 1, 0}) {
      const auto pose = at.find(is_count ? time : time + off);
      if (pose != at.end()) found[pose->second] = in_dimension<Dim>(line.pose);
    }
  }
  return found;
}

}  // namespace

TruthFile::TruthFile(const std::filesystem::path& path) : path_(path.string()) {
  if (extension_of(path) == ".tum") {
    content_ = read_tum(path).value();
    return;
  }
  const AnyLog& log = content_.emplace<AnyLog>(open_log(path).value());
  const bool has_values = std::visit([](const auto& any) { return !any.initial.poses.empty(); }, log);
  if (!has_values) fail(ErrorKind::kBadInput, path_ + ": as a truth it would have to give the values of its poses");
}

template <int Dim>
Truth<Dim> TruthFile::of(const PoseIds& poses, const FeatureIds& features,
                         const Table<PoseIndex, std::int64_t>& stamps_ns) const {
  if (const auto* trajectory = std::get_if<std::vector<StampedPose>>(&content_)) {
    return {by_time<Dim>(*trajectory, poses.size(), stamps_ns), {features.size(), std::nullopt}};
  }
  const auto* log = std::get_if<Log<Dim>>(&std::get<AnyLog>(content_));
  if (!log) fail(ErrorKind::kUsage, fmt::format("{}: the truth is not in {}D, as the map is", path_, Dim));
  return {by_name(log->poses, log->initial.poses, poses), by_name(log->features, log->initial.features, features)};
}

template Truth<2> TruthFile::of(const PoseIds&, const FeatureIds&, const Table<PoseIndex, std::int64_t>&) const;
template Truth<3> TruthFile::of(const PoseIds&, const FeatureIds&, const Table<PoseIndex, std::int64_t>&) const;

}  // namespace mapjoin::apps
