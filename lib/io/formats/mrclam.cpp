// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/formats/mrclam.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kFirstLandmark = 6;

/// Velocities (m/s, rad/s) and ranges (m) beyond are no robot's.
constexpr double kMostSpeed = 1e6;
constexpr double kLeastRange = 1e-6;
constexpr double kMostRange = 1e6;

struct Velocity {
  double time = 0.0;  ///< (s), from which on it holds.
  double forward = 0.0;
  double turn = 0.0;
};

struct Sighting {
  double time = 0.0;
  std::uint64_t barcode = 0;
  double range = 0.0;
  double bearing = 0.0;
};

using Subjects = std::map<std::uint64_t, std::uint64_t>;  ///< By barcode.

fs::path file_in(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  const fs::path packed = folder / (name + ".gz");
  return fs::exists(packed, ignored) ? packed : folder / name;
}

/// Hands every line of a file to `read`.
template <typename Read>
Expected<void> read_lines(const fs::path& path, const Read& read) {
  return FileBytes::read(path).and_then([&](const FileBytes& bytes) {
    TextScanner text(path.string(), bytes.view());
    return text.each_line([&] { read(text); });
  });
}

/// Times are told apart to the nanosecond in 64 bits.
double read_time(TextScanner& text) {
  constexpr double kMost = 9e9;
  const double time = text.number();
  if (std::abs(time) > kMost) text.reject("a time must be below 9e9 s");
  return time;
}

/// In the order of their times.
template <typename Line, typename Read>
Expected<std::vector<Line>> read_timed(const fs::path& path, const Read& read) {
  std::vector<Line> lines;
  return read_lines(path, [&](TextScanner& text) { lines.push_back(read(text)); }).map([&] {
    std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.time < b.time; });
    return std::move(lines);
  });
}

Expected<std::vector<Velocity>> read_odometry(const fs::path& path) {
  return read_timed<Velocity>(path, [](TextScanner& text) {
    const double time = read_time(text);
    const Vector<2> v = text.vector<2>();
    if (v.cwiseAbs().maxCoeff() > kMostSpeed) text.reject("a velocity must be below 1e6 m/s or rad/s");
    return Velocity{time, v[0], v[1]};
  });
}

Expected<std::vector<Sighting>> read_sightings(const fs::path& path) {
  return read_timed<Sighting>(path, [](TextScanner& text) {
    Sighting seen;
    seen.time = read_time(text);
    seen.barcode = text.key();
    seen.range = text.number();
    if (!(seen.range > kLeastRange && seen.range < kMostRange)) text.reject("a range must be from 1e-6 to 1e6 m");
    seen.bearing = text.number();
    return seen;
  });
}

/// The motion since the last pose, and its covariance.
struct Motion {
  Pose<2> moved;
  Matrix<3> P = Matrix<3>::Zero();
};

/// Along an arc for `seconds`.
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

/// Takes a robot's motion from time to time.
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

/// A range and bearing as a position, weighed.
void observe(PoseId pose, FeatureId landmark, const Sighting& seen, const MrclamNoise& noise, LogBuilder<2>& builder) {
  const Point<2> ahead(std::cos(seen.bearing), std::sin(seen.bearing));
  Matrix<2> R;  // Along the sight, and across it.
  R << ahead.x(), -ahead.y(), ahead.y(), ahead.x();
  const Vector<2> deviations(noise.range, seen.range * noise.bearing);
  const Matrix<2> W = R * deviations.cwiseAbs2().cwiseInverse().asDiagonal() * R.transpose();
  builder.add_observation(pose, landmark, seen.range * ahead, 0.5 * (W + W.transpose()));
}

/// One robot's poses and what it saw.
Expected<void> add_robot(std::uint32_t session, const std::vector<Velocity>& odometry, const std::vector<Sighting>& sightings,
                         const Subjects& subjects, const MrclamNoise& noise, LogBuilder<2>& builder) {
  constexpr double kLeastSeconds = 1e-4;  // Closer sightings are of one pose: their motion would have no covariance.
  Driver driver(odometry, noise);
  PoseId pose{session, 0};
  double pose_time = odometry.front().time;
  builder.add_stamp(pose, nanoseconds(pose_time));
  for (const Sighting& seen : sightings) {
    const auto subject = subjects.find(seen.barcode);
    if (subject == subjects.end() || subject->second < kFirstLandmark || seen.time < odometry.front().time) {
      builder.add_unassociated();
      continue;
    }
    if (seen.time - pose_time > kLeastSeconds) {
      const Motion motion = driver.drive_to(seen.time);
      const Pose<2> moved{motion.moved.translation, Rotation<2>(motion.moved.rotation.log()[0])};
      const PoseId next{session, pose.key + 1};
      const auto W = information_of_covariance<3>(0.5 * (motion.P + motion.P.transpose()));
      if (!W)
        return bad_input(
            fmt::format("robot {} moves too far until the time {} for its motion to be weighed", session + 1, seen.time));
      builder.add_pose_edge(pose, next, moved, *W);
      pose = next;
      pose_time = seen.time;
      builder.add_stamp(pose, nanoseconds(pose_time));
    }
    observe(pose, {subject->second}, seen, noise, builder);
  }
  return {};
}

Expected<Subjects> read_subjects(const fs::path& path) {
  Subjects subjects;
  return read_lines(path,
                    [&](TextScanner& text) {
                      const std::uint64_t subject = text.key();
                      if (!subjects.emplace(text.key(), subject).second) text.reject("this barcode is there a second time");
                    })
      .map([&] { return std::move(subjects); });
}

}  // namespace

bool is_mrclam_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path / "Barcodes.dat", ignored);
}

Expected<AnyLog> read_mrclam(const fs::path& folder, const MrclamNoise& noise) {
  const auto subjects = read_subjects(folder / "Barcodes.dat");
  if (!subjects) return tl::unexpected(subjects.error());
  LogBuilder<2> builder(folder.string());
  std::error_code ignored;
  for (std::uint32_t robot = 1; robot < kFirstLandmark; ++robot) {
    const fs::path odometry_file = file_in(folder, fmt::format("Robot{}_Odometry.dat", robot));
    if (!fs::exists(odometry_file, ignored)) continue;
    const auto odometry = read_odometry(odometry_file);
    if (!odometry) return tl::unexpected(odometry.error());
    if (odometry->empty()) return bad_input(odometry_file.string() + ": there is no odometry");
    const auto sightings = read_sightings(file_in(folder, fmt::format("Robot{}_Measurement.dat", robot)));
    if (!sightings) return tl::unexpected(sightings.error());
    const auto added = add_robot(robot - 1, *odometry, *sightings, *subjects, noise, builder);
    if (!added) return bad_input(folder.string() + ": " + added.error().message);
  }
  return std::move(builder).finish();
}

}  // namespace mapjoin
