// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mapjoin/io/information.hpp>
#include <mapjoin/io/store_check.hpp>

namespace mapjoin::store {
namespace {

tl::unexpected<Error> damaged(const std::string& file, const std::string& what) {
  return bad_input(fmt::format("{}: damaged store: {}", file, what));
}

template <int Dim>
bool is_sound(const Point<Dim>& point) {
  return point.allFinite();
}
bool is_sound(const Rotation<2>& rotation) {
  return std::isfinite(rotation.angle());
}
bool is_sound(const Rotation<3>& rotation) {
  return std::abs(rotation.quaternion().norm() - 1.0) < 1e-9;
}
template <int Dim>
bool is_sound(const Pose<Dim>& pose) {
  return pose.translation.allFinite() && is_sound(pose.rotation);
}
template <int Size>
bool is_information(Matrix<Size> W) {
  return W.rows() == 0 || !InformationCheck(false).fault<Size>(W);
}

bool is_index(Index index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

/// Observations from poses, or from the World, of `targets` poses or features.
template <typename Observation>
Expected<void> check_observations(const std::vector<Observation>& observations, const char* name, std::size_t poses,
                                  bool from_world, std::size_t targets, const std::string& file) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& o = observations[i];
    const bool base_ok = from_world ? o.base == kWorld : is_index(o.base, poses);
    if (!base_ok || !is_index(o.target, targets)) return damaged(file, fmt::format("{} {} names no pose or feature", name, i));
    if (!is_sound(o.measured) || o.loss != Loss::kQuadratic || !is_information(o.information)) {
      return damaged(file, fmt::format("{} {} is no observation", name, i));
    }
  }
  return {};
}

/// As many values as there are names, or none; all sound.
template <typename Value>
Expected<void> check_values(const std::vector<Value>& values, const char* name, std::size_t names, const std::string& file) {
  if (!values.empty() && values.size() != names) return damaged(file, fmt::format("{} are not as many as their names", name));
  if (std::all_of(values.begin(), values.end(), [](const Value& value) { return is_sound(value); })) return {};
  return damaged(file, fmt::format("{} are not finite", name));
}

/// Each once, and ascending.
template <typename Items, typename By = std::identity>
bool ascend(const Items& items, By by = {}) {
  return std::ranges::adjacent_find(items, std::greater_equal(), by) == items.end();
}

template <int Dim>
Expected<void> check_names(const Log<Dim>& log, const std::string& file) {
  if (log.poses.empty()) return damaged(file, "it has no poses");
  if (!ascend(log.poses) || !ascend(log.features)) return damaged(file, "its poses or features are not in order");
  Index next = 0;
  for (const Session& session : log.sessions) {
    if (session.begin != next || session.end <= session.begin || !is_index(session.end - 1, log.poses.size())) {
      return damaged(file, "its sessions are not in order");
    }
    next = session.end;
  }
  if (static_cast<std::size_t>(next) != log.poses.size()) return damaged(file, "its sessions do not hold every pose");
  if (!log.stamps_ns.empty() && log.stamps_ns.size() != log.poses.size()) {
    return damaged(file, "its time stamps are not as many as its poses");
  }
  for (const FixedPose<Dim>& fixed : log.fixed) {
    if (!is_index(fixed.pose, log.poses.size()) || !is_sound(fixed.value)) return damaged(file, "a fixed pose is none");
  }
  if (!ascend(log.fixed, &FixedPose<Dim>::pose)) return damaged(file, "its fixed poses are not in order");
  return {};
}

/// The order that Log promises: odometry between successive poses of a session, by the later one; observations by their pose.
template <int Dim>
Expected<void> check_order(const Log<Dim>& log, const std::string& file) {
  auto session = log.sessions.begin();
  Index latest = 0;
  for (const auto& o : log.odometry) {
    const auto [earlier, later] = std::minmax(o.base, o.target);
    if (later != earlier + 1 || later < latest) return damaged(file, "its odometry is not in order");
    while (session->end <= earlier) ++session;
    if (session->end <= later) return damaged(file, "its odometry leaves a session");
    latest = later;
  }
  const auto is_loop = [](const auto& o) { return o.base == o.target; };
  if (std::any_of(log.closures.begin(), log.closures.end(), is_loop))
    return damaged(file, "a closure leads from a pose to itself");
  const auto by_pose = [](const auto& a, const auto& b) { return a.base < b.base; };
  if (std::is_sorted(log.observations.begin(), log.observations.end(), by_pose)) return {};
  return damaged(file, "its observations are not in order");
}

}  // namespace

template <int Dim>
Expected<void> check_log(const Log<Dim>& log, const std::string& file) {
  const std::size_t poses = log.poses.size();
  const std::size_t features = log.features.size();
  return check_names(log, file)
      .and_then([&] { return check_observations(log.odometry, "odometry", poses, false, poses, file); })
      .and_then([&] { return check_observations(log.closures, "closures", poses, false, poses, file); })
      .and_then([&] { return check_observations(log.observations, "observations", poses, false, features, file); })
      .and_then([&] { return check_order(log, file); })
      .and_then([&] { return check_observations(log.pose_priors, "pose_priors", poses, true, poses, file); })
      .and_then([&] { return check_observations(log.feature_priors, "feature_priors", poses, true, features, file); })
      .and_then([&] { return check_values(log.initial_poses, "initial_poses", poses, file); })
      .and_then([&] { return check_values(log.initial_features, "initial_features", features, file); });
}

template <int Dim>
Expected<void> check_stretches(const std::vector<Stretch>& stretches, const Log<Dim>& log, const std::string& file) {
  Index begin = 0;
  for (const Stretch& stretch : stretches) {
    if (stretch.begin < begin || stretch.end < stretch.begin || !is_index(stretch.end, log.poses.size())) {
      return damaged(file, "its stretches are not in order");
    }
    begin = stretch.end;
  }
  return {};
}

template <int Dim>
Expected<void> check_map(const LocalMap<Dim>& map, const Stretch& stretch, const Log<Dim>& log, const std::string& file) {
  const auto wrong = [&] {
    return damaged(file, fmt::format("the local map of {} to {} makes no sense",
                                     to_string(log.poses[static_cast<std::size_t>(stretch.begin)]),
                                     to_string(log.poses[static_cast<std::size_t>(stretch.end)])));
  };
  Index last = stretch.begin;
  for (const Index pose : map.poses) {
    if (pose <= last || pose > stretch.end) return wrong();
    last = pose;
  }
  if (map.base != stretch.begin || last != stretch.end || !std::isfinite(map.chi2)) return wrong();
  std::vector<Index> features = map.features;
  std::sort(features.begin(), features.end());
  if (std::adjacent_find(features.begin(), features.end()) != features.end()) return wrong();
  if (!features.empty() && !(features.front() >= 0 && is_index(features.back(), log.features.size()))) return wrong();
  if (map.pose_estimates.size() != map.poses.size() || map.feature_estimates.size() != map.features.size()) return wrong();
  const auto sound = [](const auto& value) { return is_sound(value); };
  if (!std::all_of(map.pose_estimates.begin(), map.pose_estimates.end(), sound) ||
      !std::all_of(map.feature_estimates.begin(), map.feature_estimates.end(), sound) ||
      !is_information<Eigen::Dynamic>(map.information)) {
    return wrong();
  }
  return {};
}

template Expected<void> check_log<2>(const Log<2>&, const std::string&);
template Expected<void> check_log<3>(const Log<3>&, const std::string&);
template Expected<void> check_stretches<2>(const std::vector<Stretch>&, const Log<2>&, const std::string&);
template Expected<void> check_stretches<3>(const std::vector<Stretch>&, const Log<3>&, const std::string&);
template Expected<void> check_map<2>(const LocalMap<2>&, const Stretch&, const Log<2>&, const std::string&);
template Expected<void> check_map<3>(const LocalMap<3>&, const Stretch&, const Log<3>&, const std::string&);

}  // namespace mapjoin::store
