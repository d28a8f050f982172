// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/covariance_text.hpp>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/g2o_numbering.hpp>
#include <mapjoin/io/gtsam_text.hpp>
#include <mapjoin/io/isam.hpp>
#include <mapjoin/io/log_format.hpp>
#include <mapjoin/io/map_text.hpp>
#include <mapjoin/io/mat_log.hpp>
#include <mapjoin/io/toro.hpp>
#include <mapjoin/model/counted.hpp>

namespace mapjoin {
namespace {

enum class Weights : std::uint8_t { kExact, kAngles, kSquareRoot, kCovariance };

/// What a format has a place for.
struct Room {
  bool edges = true;
  bool observations = true;
  bool pose_values = false;
  bool feature_values = false;
  bool fixed = false;
  bool stamps = false;
  bool names = true;
  bool one_numbering = false;  ///< Of poses and features.
  Weights weights = Weights::kExact;
};

Room room_in(LogFormat format) {
  switch (format) {
    case LogFormat::kG2o:
      return {.pose_values = true, .feature_values = true, .fixed = true, .one_numbering = true};
    case LogFormat::kToro:
      return {.observations = false, .pose_values = true, .weights = Weights::kAngles};
    case LogFormat::kIsam:
      return {.weights = Weights::kSquareRoot};
    case LogFormat::kGtsam:
      return {.one_numbering = true, .weights = Weights::kCovariance};
    case LogFormat::kOdomObs:
    case LogFormat::kMat:
      return {.weights = Weights::kCovariance};
    case LogFormat::kTum:
      return {.edges = false, .observations = false, .pose_values = true, .stamps = true, .names = false};
    case LogFormat::kKitti:
      return {.edges = false, .observations = false, .pose_values = true, .names = false};
  }
  return {};
}

bool is_planar(LogFormat format) {
  return format == LogFormat::kGtsam || format == LogFormat::kOdomObs || format == LogFormat::kMat;
}

/// How many poses and features no edge mentions.
template <int Dim>
std::size_t unmentioned(const Log<Dim>& log) {
  std::vector<bool> pose(log.poses.size());
  std::vector<bool> feature(log.features.size());
  for (const auto* list : {&log.odometry, &log.closures}) {
    for (const auto& edge : *list)
      pose[static_cast<std::size_t>(edge.base)] = pose[static_cast<std::size_t>(edge.target)] = true;
  }
  for (const auto& o : log.observations) {
    pose[static_cast<std::size_t>(o.base)] = feature[static_cast<std::size_t>(o.target)] = true;
  }
  return static_cast<std::size_t>(std::count(pose.begin(), pose.end(), false) +
                                  std::count(feature.begin(), feature.end(), false));
}

template <int Dim>
void tell_numbering(const Log<Dim>& log, const Room& room, std::vector<std::string>& lost) {
  const auto numbering = number_for_g2o(log.poses, room.one_numbering ? log.features : std::vector<FeatureId>());
  if (!numbering) return;  // The writer says why.
  if (numbering->session_step > 0) {
    lost.push_back(fmt::format("poses of session n are numbered from n times {} on", numbering->session_step));
  }
  if (numbering->feature_offset > 0) {
    lost.push_back(fmt::format("features are numbered from {} on, apart from poses", numbering->feature_offset));
  }
}

template <int Dim>
void tell_rounding(const Room& room, std::vector<std::string>& lost) {
  if (room.weights == Weights::kSquareRoot) lost.emplace_back("weights are square roots of information matrices, rounded");
  if (room.weights == Weights::kCovariance) lost.emplace_back("weights are covariances, rounded");
  const bool has_angles = room.weights == Weights::kAngles || room.weights == Weights::kSquareRoot;
  if (Dim == 3 && has_angles) lost.emplace_back("rotations and their weights are those of roll, pitch and yaw, rounded");
}

template <int Dim>
GlobalMap<Dim> values_of(const Log<Dim>& log) {
  GlobalMap<Dim> map;
  map.pose_ids = log.poses;
  map.poses = log.initial_poses;
  map.stamps_ns = log.stamps_ns;
  return map;
}

Expected<void> write_planar(const Log<2>& log, LogFormat format, const std::filesystem::path& path) {
  if (format == LogFormat::kGtsam) return write_gtsam_text(log, path);
  return format == LogFormat::kMat ? write_mat_log(log, path) : write_odom_obs(log, path);
}
Expected<void> write_planar(const Log<3>& log, LogFormat format, const std::filesystem::path&) {
  return tl::unexpected(
      Error{ErrorKind::kUsage, fmt::format("{}: the format {} is for the plane", log.source, to_string(format))});
}

/// g2o files with what they have no line for left out.
template <int Dim>
Expected<void> write_as_g2o(const Log<Dim>& log, const std::filesystem::path& path) {
  if (log.pose_priors.empty() && log.feature_priors.empty()) return write_g2o(log, path);
  Log<Dim> without = log;
  without.pose_priors.clear();
  without.feature_priors.clear();
  return write_g2o(without, path);
}

}  // namespace

bool are_counted(const std::vector<PoseId>& poses) {
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (poses[k] != PoseId{0, k}) return false;
  }
  return true;
}

bool needs_values(LogFormat format) {
  const Room room = room_in(format);
  return room.pose_values && !room.feature_values;
}

template <int Dim>
std::vector<std::string> losses(const Log<Dim>& log, LogFormat format) {
  const Room room = room_in(format);
  std::vector<std::string> lost;
  const auto tell = [&](std::size_t count, const std::string& what) {
    if (count > 0) lost.push_back(fmt::format("{} left out", what));
  };
  const std::size_t edges = log.odometry.size() + log.closures.size();
  if (!room.edges) tell(edges, counted(edges, "pose-pose edge"));
  if (!room.observations) {
    tell(log.features.size(),
         counted(log.features.size(), "feature") + " with " + counted(log.observations.size(), "observation"));
  }
  const std::size_t priors = log.pose_priors.size() + log.feature_priors.size();
  tell(priors, counted(priors, "prior"));
  if (!room.fixed) tell(log.fixed.size(), "which poses are fixed is");
  const bool has_values = !log.initial_poses.empty() || !log.initial_features.empty();
  const bool all_values = !log.initial_poses.empty() && log.initial_features.size() == log.features.size();
  if (!room.pose_values || (room.feature_values && !all_values))
    tell(has_values ? 1 : 0, "the values of poses and features are");
  if (!room.stamps) tell(log.stamps_ns.size(), "time stamps are");
  const bool names_all = needs_values(format) || (room.feature_values && all_values);
  if (!names_all) tell(unmentioned(log), "poses and features that no edge mentions are");
  if (room.names) {
    tell_numbering(log, room, lost);
  } else {
    if (!are_counted(log.poses)) lost.emplace_back("poses are counted, not named");
    if (Dim == 2) lost.emplace_back("headings are rotations in space, rounded");
    if (Dim == 3 && format == LogFormat::kKitti) lost.emplace_back("rotations are matrices, rounded");
  }
  tell_rounding<Dim>(room, lost);
  return lost;
}

template <int Dim>
Expected<void> write_log(const Log<Dim>& log, LogFormat format, const std::filesystem::path& path) {
  if (is_planar(format)) return write_planar(log, format, path);
  if (needs_values(format) && log.initial_poses.empty()) {
    return tl::unexpected(Error{ErrorKind::kUsage,
                                fmt::format("{}: the format {} needs the values of all poses", log.source, to_string(format))});
  }
  if (format == LogFormat::kToro) return write_toro(log, path);
  if (format == LogFormat::kIsam) return write_isam(log, path);
  if (format == LogFormat::kTum) return write_tum(values_of(log), path);
  if (format == LogFormat::kKitti) return write_kitti(values_of(log), path);
  return write_as_g2o(log, path);
}

template std::vector<std::string> losses(const Log<2>&, LogFormat);
template std::vector<std::string> losses(const Log<3>&, LogFormat);
template Expected<void> write_log(const Log<2>&, LogFormat, const std::filesystem::path&);
template Expected<void> write_log(const Log<3>&, LogFormat, const std::filesystem::path&);

}  // namespace mapjoin
