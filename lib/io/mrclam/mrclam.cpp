// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <mapjoin/io/mrclam/mrclam.hpp>
#include <mapjoin/io/mrclam/team.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {
namespace mrclam {
namespace {

/// The motion since the last pose, and its covariance.
struct Motion {
  Pose<2> moved;
  Matrix<3> P = Matrix<3>::Zero();
};

/// Appends motion along an arc for `seconds` (s).
void move_on(const Velocity& velocity, double seconds, const MrclamNoise& noise, Motion& motion) {
  const double turned = velocity.turn * seconds;
  const double chord = std::abs(turned) < 1e-9 ? 1.0 : std::sin(0.5 * turned) / (0.5 * turned);
  const double way = velocity.forward * seconds * chord;
  const Pose<2> step{way * Point<2>(std::cos(0.5 * turned), std::sin(0.5 * turned)), Rotation<2>(turned)};
  Matrix<3> J_before;
  Matrix<3> J_step;
  motion.moved = compose(motion.moved, step, &J_before, &J_step);
  const Vector<3> deviations(noise.forward, noise.sideways, noise.turn);
  const Matrix<3> Q = (seconds * deviations.cwiseAbs2()).asDiagonal();
  motion.P = J_before * motion.P * J_before.transpose() + J_step * Q * J_step.transpose();
}

/// Integrates a robot's motion from one time to the next.
class Driver {
 public:
  Driver(const std::vector<Velocity>& odometry, const MrclamNoise& noise)
      : odometry_(odometry), noise_(noise), now_(odometry.front().time) {}

  Motion drive_to(double time) {
    Motion motion;
    while (now_ < time) {
      while (at_ + 1 < odometry_.size() && odometry_[at_ + 1].time <= now_) ++at_;
      const double next = at_ + 1 < odometry_.size() ? std::min(time, odometry_[at_ + 1].time) : time;
      move_on(odometry_[at_], next - now_, noise_, motion);
      now_ = next;
    }
    return motion;
  }

 private:
  const std::vector<Velocity>& odometry_;
  MrclamNoise noise_;
  double now_;
  std::size_t at_ = 0;
};

std::int64_t nanoseconds(double seconds) {
  return std::llround(1e9 * seconds);
}

/// The position of something seen, in the frame of the robot.
struct Position {
  Point<2> value;
  Matrix<2> information;
};

Position position_of(const BarcodeSighting& seen, const MrclamNoise& noise) {
  const Point<2> ahead(std::cos(seen.bearing), std::sin(seen.bearing));
  Matrix<2> R;  // Columns along the line of sight, and across it.
  R << ahead.x(), -ahead.y(), ahead.y(), ahead.x();
  const Vector<2> deviations(noise.range, seen.range * noise.bearing);
  const Matrix<2> W = R * deviations.cwiseAbs2().cwiseInverse().asDiagonal() * R.transpose();
  return {seen.range * ahead, 0.5 * (W + W.transpose())};
}

/// The times at which the robots see something or are seen, ascending.
std::map<std::uint64_t, std::vector<double>> times_of_poses(const Team& team) {
  std::map<std::uint64_t, std::vector<double>> times;
  for (const auto& [subject, robot] : team.robots) {
    times[subject].push_back(robot.odometry.front().time);
    for (const BarcodeSighting& seen : robot.sightings) {
      const auto other = team.subject_of(seen, subject);
      if (!other) continue;
      times[subject].push_back(seen.time);
      if (!is_landmark(*other)) times[*other].push_back(seen.time);
    }
  }
  for (auto& [subject, all] : times) std::ranges::sort(all);
  return times;
}

/// The poses of a robot by their times (s).
using Poses = std::map<double, PoseId>;

/// Adds the odometry of a robot from one pose to the next, at `time` (s).
Expected<void> add_step(PoseId pose, PoseId next, double time, Driver& driver, LogBuilder<2>& builder) {
  const Motion motion = driver.drive_to(time);
  const auto W = information_of_covariance<3>(0.5 * (motion.P + motion.P.transpose()));
  if (!W) {
    return bad_input(
        fmt::format("robot {} moves too far until the time {} for its motion to be weighed", pose.session + 1, time));
  }
  builder.add_pose_edge(pose, next, {motion.moved.translation, Rotation<2>(motion.moved.rotation.log()[0])}, *W);
  return {};
}

/// Adds the poses of a robot at `times` (s), which ascend, and the odometry between them.
Expected<Poses> add_poses(std::uint32_t session, const Robot& robot, const std::vector<double>& times, const MrclamNoise& noise,
                          LogBuilder<2>& builder) {
  constexpr double kLeastSeconds = 1e-4;  // Closer sightings share a pose: the motion between would have no covariance.
  Driver driver(robot.odometry, noise);
  Poses poses;
  PoseId pose{session, 0};
  double pose_time = times.front();
  builder.add_stamp(pose, nanoseconds(pose_time));
  for (const double time : times) {
    if (time - pose_time > kLeastSeconds) {
      const PoseId next{session, pose.key + 1};
      if (auto added = add_step(pose, next, time, driver, builder); !added) return tl::unexpected(added.error());
      builder.add_stamp(next, nanoseconds(time));
      pose = next;
      pose_time = time;
    }
    poses.emplace(time, pose);
  }
  return poses;
}

/// Adds a robot that is seen as a closure that measures its position, not its rotation.
void add_meeting(PoseId pose, PoseId other, const Position& position, LogBuilder<2>& builder) {
  Matrix<3> W = Matrix<3>::Zero();
  W.topLeftCorner<2, 2>() = position.information;
  builder.add_pose_edge(pose, other, {position.value, Rotation<2>()}, W);
}

/// Adds the robots' sightings, from their poses by subject.
void add_sightings(const Team& team, const std::map<std::uint64_t, Poses>& poses, const MrclamNoise& noise,
                   LogBuilder<2>& builder) {
  for (const auto& [subject, robot] : team.robots) {
    for (const BarcodeSighting& seen : robot.sightings) {
      const auto other = team.subject_of(seen, subject);
      if (!other) {
        const std::string_view kind = team.kind_left_out(seen, subject);
        kind.empty() ? builder.add_unassociated() : builder.add_skipped(kind);
        continue;
      }
      const PoseId pose = poses.at(subject).at(seen.time);
      const Position position = position_of(seen, noise);
      if (is_landmark(*other)) {
        builder.add_observation(pose, {*other}, position.value, position.information);
      } else {
        add_meeting(pose, poses.at(*other).at(seen.time), position, builder);
      }
    }
  }
}

Expected<void> add_team(const Team& team, const MrclamNoise& noise, LogBuilder<2>& builder) {
  std::map<std::uint64_t, Poses> poses;
  for (const auto& [subject, times] : times_of_poses(team)) {
    auto added = add_poses(static_cast<std::uint32_t>(subject - 1), team.robots.at(subject), times, noise, builder);
    if (!added) return tl::unexpected(added.error());
    poses[subject] = *std::move(added);
  }
  add_sightings(team, poses, noise, builder);
  return {};
}

}  // namespace
}  // namespace mrclam

bool is_mrclam_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path / "Barcodes.dat", ignored);
}

Expected<AnyLog> read_mrclam(const std::filesystem::path& folder, const MrclamNoise& noise) {
  auto team = mrclam::read_team(folder);
  if (!team) return tl::unexpected(team.error());
  LogBuilder<2> builder(folder.string());
  const auto added = mrclam::add_team(*team, noise, builder);
  if (!added) return bad_input(folder.string() + ": " + added.error().message);
  return std::move(builder).finish();
}

}  // namespace mapjoin
