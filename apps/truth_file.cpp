// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/exit_code.hpp>
#include <apps/outputs.hpp>
#include <apps/truth_file.hpp>
#include <cmath>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/formats/map_text.hpp>

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

/// The poses by their count among those that are `counted`.
template <int Dim>
Table<PoseIndex, std::optional<Pose<Dim>>> by_count(const std::vector<StampedPose>& trajectory, const PoseIds& counted,
                                                    const PoseIds& poses) {
  PoseIds ids;
  Table<PoseIndex, Pose<Dim>> values;
  for (const StampedPose& line : trajectory) {
    if (line.time < 0.0 || line.time >= static_cast<double>(counted.size())) continue;
    ids.push_back(counted[PoseIndex(static_cast<std::size_t>(line.time))]);
    values.push_back(in_dimension<Dim>(line.pose));
  }
  return by_name(ids, values, poses);
}

/// The poses by their time stamps: of each the line whose time is nearest, if near enough (s).
template <int Dim>
Table<PoseIndex, std::optional<Pose<Dim>>> by_time(const std::vector<StampedPose>& trajectory,
                                                   const Table<PoseIndex, std::int64_t>& stamps_ns, double most_apart) {
  Table<PoseIndex, std::optional<Pose<Dim>>> found(stamps_ns.size());
  std::map<double, const StampedPose*> lines;
  for (const StampedPose& line : trajectory) lines.emplace(line.time, &line);
  for (const PoseIndex p : indices(found)) {
    const double time = 1e-9 * static_cast<double>(stamps_ns[p]);
    const auto apart = [&](const auto& line) { return std::abs(line.first - time); };
    auto nearest = lines.lower_bound(time);
    if (nearest == lines.end() || (nearest != lines.begin() && apart(*std::prev(nearest)) <= apart(*nearest))) {
      if (nearest == lines.begin()) continue;
      --nearest;
    }
    if (apart(*nearest) <= most_apart) found[p] = in_dimension<Dim>(nearest->second->pose);
  }
  return found;
}

/// A trajectory of KITTI's, which counts its poses.
std::vector<StampedPose> counted(const AnyLog& log) {
  std::vector<StampedPose> trajectory;
  std::visit(
      [&](const auto& any) {
        for (const auto& pose : any.initial.poses)
          trajectory.push_back({static_cast<double>(trajectory.size()), in_space(pose)});
      },
      log);
  return trajectory;
}

}  // namespace

TruthFile::TruthFile(const std::filesystem::path& path, double most_apart) : path_(path.string()), most_apart_(most_apart) {
  const FileBytes bytes = FileBytes::read(path).value();
  const TextScanner text(path_, bytes.view());
  if (extension_of(path) == ".tum" || is_tum_line(text)) {
    content_ = read_tum(text).value();
    return;
  }
  if (is_kitti_line(text)) {
    content_ = counted(read_kitti_log(text, {}).value());
    return;
  }
  const AnyLog& log = content_.emplace<AnyLog>(mapjoin::read_log(bytes.view(), path_, {}).value());
  const bool has_values = std::visit([](const auto& any) { return !any.initial.poses.empty(); }, log);
  if (!has_values) fail(ErrorKind::kBadInput, path_ + ": as a truth it would have to give the values of its poses");
}

void TruthFile::demand_counts() const {
  const auto* trajectory = std::get_if<std::vector<StampedPose>>(&content_);
  const auto is_count = [](const StampedPose& line) { return line.time == std::floor(line.time); };
  if (!trajectory || std::ranges::all_of(*trajectory, is_count)) return;
  fail(ErrorKind::kUsage, path_ +
                              ": has times, and the poses of the map have none; --stamps gives a log's, and poses.csv in "
                              "the folder of a run has them");
}

void TruthFile::count_among(const PoseIds& poses) {
  demand_counts();
  counted_ = poses;
}

template <int Dim>
Truth<Dim> TruthFile::of(const PoseIds& poses, const FeatureIds& features,
                         const Table<PoseIndex, std::int64_t>& stamps_ns) const {
  if (const auto* trajectory = std::get_if<std::vector<StampedPose>>(&content_)) {
    const Table<FeatureIndex, std::optional<Point<Dim>>> no_features(features.size());
    if (!stamps_ns.empty()) return {by_time<Dim>(*trajectory, stamps_ns, most_apart_), no_features};
    demand_counts();
    return {by_count<Dim>(*trajectory, counted_.empty() ? poses : counted_, poses), no_features};
  }
  const auto* log = std::get_if<Log<Dim>>(&std::get<AnyLog>(content_));
  if (!log) fail(ErrorKind::kUsage, fmt::format("{}: the truth is not in {}D, as the map is", path_, Dim));
  return {by_name(log->poses, log->initial.poses, poses), by_name(log->features, log->initial.features, features)};
}

std::vector<std::pair<PoseIndex, PoseIndex>> TruthFile::relations(const PoseIds& poses) const {
  std::vector<std::pair<PoseIndex, PoseIndex>> pairs;
  if (const auto* log = std::get_if<AnyLog>(&content_)) {
    const IndexOf index_of(poses);
    const auto add = [&](const auto& any) {
      for (const auto& edge : any.edges()) {
        const auto base = index_of(any.poses[edge.base]);
        const auto target = index_of(any.poses[edge.target]);
        if (base && target) pairs.emplace_back(*base, *target);
      }
    };
    std::visit(add, *log);
  }
  return pairs;
}

template Truth<2> TruthFile::of(const PoseIds&, const FeatureIds&, const Table<PoseIndex, std::int64_t>&) const;
template Truth<3> TruthFile::of(const PoseIds&, const FeatureIds&, const Table<PoseIndex, std::int64_t>&) const;

}  // namespace mapjoin::apps
