// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <stdexcept>
#include <system_error>

namespace mapjoin {
namespace {

template <int Dim>
void put_poses(const GlobalMap<Dim>& map, OutputFile& file) {
  const bool has_stamps = !map.stamps_ns.empty();
  const bool has_sessions = std::any_of(map.pose_ids.begin(), map.pose_ids.end(), [](auto& id) { return id.session != 0; });
  TextLine line(',');
  if (has_sessions) line.add("session");
  line.add(Dim == 2 ? "pose,x,y,phi" : "pose,x,y,z,qx,qy,qz,qw");
  if (has_stamps) line.add("stamp_ns");
  const bool has_covariances = !map.pose_covariances.empty();
  if (has_covariances) line.add_covariance_names(step_names<Dim>());
  line.write_to(file);
  for (const PoseIndex i : indices(map.poses)) {
    if (has_sessions) line.add(map.pose_ids[i].session);
    line.add(key_text(map.pose_ids[i].key)).add(map.poses[i]);
    if (has_stamps) line.add(map.stamps_ns[i]);
    if (has_covariances) line.add_symmetric<kPoseDof<Dim>>(map.pose_covariances[i]);
    line.write_to(file);
  }
}

template <int Dim>
void put_features(const GlobalMap<Dim>& map, OutputFile& file) {
  TextLine line(',');
  line.add(Dim == 2 ? "feature,x,y" : "feature,x,y,z");
  const bool has_covariances = !map.feature_covariances.empty();
  if (has_covariances) line.add_covariance_names(step_names<Dim>(Dim));
  line.write_to(file);
  for (const FeatureIndex i : indices(map.features)) {
    line.add(key_text(map.feature_ids[i].key)).template add<Dim>(map.features[i]);
    if (has_covariances) line.template add_symmetric<Dim>(map.feature_covariances[i]);
    line.write_to(file);
  }
}

/// Throws std::invalid_argument unless `list` has one element for each of `all`.
template <typename List, typename All>
void demand_each(const List& list, const All& all, const char* what) {
  if (list.size() == all.size()) return;
  throw std::invalid_argument(fmt::format("a map has {} {}, but {} of these", list.size(), what, all.size()));
}

/// Throws std::invalid_argument unless `list` is empty or has one element for each of `all`.
template <typename List, typename All>
void demand_all_or_none(const List& list, const All& all, const char* what) {
  if (!list.empty()) demand_each(list, all, what);
}

}  // namespace

Pose<3> in_space(const Pose<2>& pose) {
  const double half = 0.5 * pose.rotation.log()[0];
  const Eigen::Quaterniond about_z(std::cos(half), 0.0, 0.0, std::sin(half));
  return {Point<3>(pose.translation.x(), pose.translation.y(), 0.0), Rotation<3>(about_z)};
}

std::string seconds(std::int64_t nanoseconds) {
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  const std::int64_t whole = nanoseconds / kNanosecondsPerSecond;
  const std::int64_t rest = nanoseconds % kNanosecondsPerSecond;  // Has the sign of `nanoseconds`.
  return fmt::format("{}{}.{:09}", nanoseconds < 0 ? "-" : "", std::abs(whole), std::abs(rest));
}

template <int Dim>
void demand_whole(const GlobalMap<Dim>& map) {
  demand_each(map.pose_ids, map.poses, "names of poses");
  demand_each(map.feature_ids, map.features, "names of features");
  demand_all_or_none(map.stamps_ns, map.poses, "stamps of poses");
  demand_all_or_none(map.pose_covariances, map.poses, "covariances of poses");
  demand_all_or_none(map.feature_covariances, map.features, "covariances of features");
  const auto is_finite = [](const auto& covariance) { return covariance.allFinite(); };
  if (!is_valid(map) || !std::ranges::all_of(map.pose_covariances, is_finite) ||
      !std::ranges::all_of(map.feature_covariances, is_finite)) {
    throw std::invalid_argument("a map has a value that is not finite, or no rotation");
  }
  const auto is_missing = [&](PoseIndex pose) { return pose.position() >= map.poses.size(); };
  if (std::ranges::any_of(map.gauge, is_missing)) throw std::invalid_argument("a map is anchored at a pose that is not in it");
}

template <int Dim>
Expected<void> write_tum(const GlobalMap<Dim>& map, const std::filesystem::path& path) {
  demand_whole(map);
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  const bool has_stamps = !map.stamps_ns.empty();
  TextLine line(' ');
  line.add(has_stamps ? "# time[s] x y z qx qy qz qw" : "# index x y z qx qy qz qw (the poses have no time stamps)");
  line.write_to(*file);
  for (const PoseIndex i : indices(map.poses)) {
    if (has_stamps) {
      line.add(seconds(map.stamps_ns[i]));
    } else {
      line.add(i.value);
    }
    line.add(in_space(map.poses[i])).write_to(*file);
  }
  return file->commit();
}

template <int Dim>
Expected<void> write_kitti(const GlobalMap<Dim>& map, const std::filesystem::path& path) {
  demand_whole(map);
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  TextLine line(' ');
  for (const Pose<Dim>& pose : map.poses) {
    const Pose<3> as_3d = in_space(pose);
    const Matrix<3> R = as_3d.rotation.matrix();
    for (int row = 0; row < 3; ++row) line.add<3>(R.row(row).transpose()).add(as_3d.translation[row]);
    line.write_to(*file);
  }
  return file->commit();
}

template <int Dim>
Expected<void> write_pose_csv(const GlobalMap<Dim>& map, const std::filesystem::path& path) {
  demand_whole(map);
  return OutputFile::create(path).and_then([&](OutputFile&& file) {
    put_poses(map, file);
    return file.commit();
  });
}

template <int Dim>
Expected<void> write_csv(const GlobalMap<Dim>& map, const std::filesystem::path& poses, const std::filesystem::path& features) {
  demand_whole(map);
  if (are_one_file(poses, features)) {
    return tl::unexpected(Error{
        ErrorKind::kUsage, poses.string() + ": is named for the poses and for the features; each takes a file of its own"});
  }
  auto pose_file = OutputFile::create(poses);
  if (!pose_file) return tl::unexpected(pose_file.error());
  auto feature_file = OutputFile::create(features);
  if (!feature_file) return tl::unexpected(feature_file.error());
  put_poses(map, *pose_file);
  put_features(map, *feature_file);
  return pose_file->sync().and_then([&] { return feature_file->commit(); }).and_then([&] { return pose_file->commit(); });
}

template void demand_whole(const GlobalMap<2>&);
template void demand_whole(const GlobalMap<3>&);
template Expected<void> write_tum(const GlobalMap<2>&, const std::filesystem::path&);
template Expected<void> write_tum(const GlobalMap<3>&, const std::filesystem::path&);
template Expected<void> write_kitti(const GlobalMap<2>&, const std::filesystem::path&);
template Expected<void> write_kitti(const GlobalMap<3>&, const std::filesystem::path&);
template Expected<void> write_pose_csv(const GlobalMap<2>&, const std::filesystem::path&);
template Expected<void> write_pose_csv(const GlobalMap<3>&, const std::filesystem::path&);
template Expected<void> write_csv(const GlobalMap<2>&, const std::filesystem::path&, const std::filesystem::path&);
template Expected<void> write_csv(const GlobalMap<3>&, const std::filesystem::path&, const std::filesystem::path&);

}  // namespace mapjoin
