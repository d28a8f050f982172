// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/io/mrclam/team.hpp>
#include <string>
#include <utility>

namespace mapjoin::mrclam {
namespace {

namespace fs = std::filesystem;

/// Bounds of velocities (m/s, rad/s) and ranges (m), beyond what any robot has.
constexpr double kMostSpeed = 1e6;
constexpr double kLeastRange = 1e-6;
constexpr double kMostRange = 1e6;

bool has_file(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// The path of a file, which may be packed; bad input if it is there in both ways.
Expected<fs::path> file_in(const fs::path& folder, const std::string& name) {
  const fs::path plain = folder / name;
  const fs::path packed = folder / (name + ".gz");
  if (!has_file(packed)) return plain;
  if (has_file(plain)) return bad_input(plain.string() + ": is there twice, packed and unpacked; remove one");
  return packed;
}

/// Hands every line of a file to `read`.
template <typename Read>
Expected<void> read_lines(const fs::path& path, const Read& read) {
  return FileBytes::read(path).and_then([&](const FileBytes& bytes) {
    TextScanner text(path.string(), bytes.view());
    return text.each_line([&] { read(text); });
  });
}

/// Reads a time (s), bounded so that its nanoseconds fit into 64 bits.
double read_seconds(TextScanner& text) {
  constexpr double kMost = 9e9;
  const double time = text.number();
  if (std::abs(time) > kMost) text.reject("a time must be below 9e9 s");
  return time;
}

/// The lines of a file, in the order of their times.
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
    const double time = read_seconds(text);
    const Vector<2> v = text.vector<2>();
    if (v.cwiseAbs().maxCoeff() > kMostSpeed) text.reject("a velocity must be below 1e6 m/s or rad/s");
    return Velocity{time, v[0], v[1]};
  });
}

Expected<std::vector<BarcodeSighting>> read_sightings(const fs::path& path) {
  return read_timed<BarcodeSighting>(path, [](TextScanner& text) {
    BarcodeSighting seen;
    seen.time = read_seconds(text);
    seen.barcode = text.key();
    seen.range = text.number();
    if (!(seen.range > kLeastRange && seen.range < kMostRange)) text.reject("a range must be from 1e-6 to 1e6 m");
    seen.bearing = text.number();
    return seen;
  });
}

Expected<std::map<std::uint64_t, std::uint64_t>> read_subjects(const fs::path& path) {
  std::map<std::uint64_t, std::uint64_t> subjects;
  return read_lines(path,
                    [&](TextScanner& text) {
                      const std::uint64_t subject = text.key();
                      if (!subjects.emplace(text.key(), subject).second) text.reject("this barcode is there a second time");
                    })
      .map([&] { return std::move(subjects); });
}

/// The odometry and sightings of a robot; nullopt if the folder has neither.
Expected<std::optional<Robot>> read_robot(const fs::path& folder, std::uint64_t subject) {
  const auto odometry_file = file_in(folder, fmt::format("Robot{}_Odometry.dat", subject));
  if (!odometry_file) return tl::unexpected(odometry_file.error());
  const auto sightings_file = file_in(folder, fmt::format("Robot{}_Measurement.dat", subject));
  if (!sightings_file) return tl::unexpected(sightings_file.error());
  if (!has_file(*odometry_file) && !has_file(*sightings_file)) return std::nullopt;
  auto odometry = read_odometry(*odometry_file);
  if (!odometry) return tl::unexpected(odometry.error());
  if (odometry->empty()) return bad_input(odometry_file->string() + ": there is no odometry");
  return read_sightings(*sightings_file).map([&](auto&& sightings) {
    return std::optional(Robot{*std::move(odometry), std::move(sightings)});
  });
}

}  // namespace

std::optional<std::uint64_t> Team::subject_of(const BarcodeSighting& seen, std::uint64_t robot) const {
  const auto subject = subjects.find(seen.barcode);
  if (subject == subjects.end() || !robots.at(robot).has_odometry_at(seen.time)) return std::nullopt;
  if (is_landmark(subject->second)) return subject->second;
  const auto other = robots.find(subject->second);
  if (other == robots.end() || other->first == robot || !other->second.has_odometry_at(seen.time)) return std::nullopt;
  return subject->second;
}

std::string_view Team::kind_left_out(const BarcodeSighting& seen, std::uint64_t robot) const {
  const auto subject = subjects.find(seen.barcode);
  if (subject == subjects.end() || subject->second == robot) return "";
  const bool is_there = is_landmark(subject->second) || robots.contains(subject->second);
  return is_there ? "sightings before the first odometry" : "sightings of robots that are not in the folder";
}

Expected<Team> read_team(const fs::path& folder) {
  auto subjects = read_subjects(folder / "Barcodes.dat");
  if (!subjects) return tl::unexpected(subjects.error());
  Team team{{}, *std::move(subjects)};
  for (std::uint64_t subject = 1; !is_landmark(subject); ++subject) {
    auto robot = read_robot(folder, subject);
    if (!robot) return tl::unexpected(robot.error());
    if (*robot) team.robots.emplace(subject, **std::move(robot));
  }
  return team;
}

}  // namespace mapjoin::mrclam
