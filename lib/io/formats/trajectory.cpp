// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/SVD>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mapjoin/io/formats/trajectory.hpp>
#include <mapjoin/io/g2o/fields.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

constexpr std::size_t kTumNumbers = 8;
constexpr std::size_t kKittiNumbers = 12;

bool has_numbers(TextScanner& line, std::size_t count) {
  if (!line.next_line()) return false;
  for (std::size_t i = 0; i < count; ++i) line.number();
  return line.finish_line().has_value();
}

/// The planar pose that a pose in space equals; nullopt if it is not in the plane.
std::optional<Pose<2>> in_plane(const Pose<3>& pose) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  if (pose.translation.z() != 0.0 || q.x() != 0.0 || q.y() != 0.0) return std::nullopt;
  return Pose<2>{pose.translation.head<2>(), Rotation<2>(wrap_angle(2.0 * std::atan2(q.z(), q.w())))};
}

template <int Dim>
Expected<AnyLog> log_of(const std::string& source, const std::vector<Pose<Dim>>& poses,
                        const std::vector<std::int64_t>& stamps) {
  LogBuilder<Dim> builder(source);
  for (std::size_t k = 0; k < poses.size(); ++k) builder.add_pose({0, k}, poses[k]);
  for (std::size_t k = 0; k < stamps.size(); ++k) builder.add_stamp({0, k}, stamps[k]);
  return std::move(builder).finish();
}

/// The log of these poses, in the plane if every pose is.
Expected<AnyLog> any_log_of(const std::string& source, const std::vector<Pose<3>>& poses,
                            const std::vector<std::int64_t>& stamps) {
  std::vector<Pose<2>> planar;
  for (const Pose<3>& pose : poses) {
    const auto flat = in_plane(pose);
    if (!flat) return log_of<3>(source, poses, stamps);
    planar.push_back(*flat);
  }
  return log_of<2>(source, planar, stamps);
}

Pose<3> read_rows(TextScanner& text) {
  constexpr double kFar = 1e-2;
  Matrix<3> R;
  Point<3> t;
  for (int row = 0; row < 3; ++row) {
    R.row(row) = text.vector<3>().transpose();
    t[row] = text.number();
  }
  const bool is_rotation = (R.transpose() * R - Matrix<3>::Identity()).norm() < kFar && R.determinant() > 0.0;
  if (!is_rotation) text.reject("the first three columns up to here are not a rotation");
  const bool is_about_z = R(2, 2) == 1.0 && R(0, 2) == 0.0 && R(1, 2) == 0.0 && R(2, 0) == 0.0 && R(2, 1) == 0.0;
  if (is_about_z) {
    const double half = 0.5 * std::atan2(R(1, 0), R(0, 0));
    return {t, Rotation<3>(Eigen::Quaterniond(std::cos(half), 0.0, 0.0, std::sin(half)))};
  }
  const Eigen::JacobiSVD<Matrix<3>> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {t, Rotation<3>(Matrix<3>(svd.matrixU() * svd.matrixV().transpose()))};
}

template <typename Number>
bool parse(std::string_view text, Number& number) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failure == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::optional<std::int64_t> nanoseconds(std::string_view word) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  if (word.find_first_of("0123456789") == word.npos) return std::nullopt;
  if (word.front() == '+' && word[1] != '-') word.remove_prefix(1);  // As numbers may have it.
  const std::size_t point = std::min(word.find('.'), word.size());
  const std::string_view fraction = word.substr(std::min(point + 1, word.size()));
  std::string digits(word.substr(0, point));
  digits += fraction.substr(0, 9);
  digits.append(9 - std::min<std::size_t>(9, fraction.size()), '0');
  using Limits = std::numeric_limits<std::int64_t>;
  std::int64_t exact = 0;
  if (fraction.find_first_not_of("0123456789") == fraction.npos && parse(digits, exact)) {
    const bool is_next_nearer = fraction.size() > 9 && fraction[9] >= '5';
    if (!is_next_nearer) return exact;
    if (exact > Limits::min() && exact < Limits::max()) return exact + (word.front() == '-' ? -1 : 1);
  }
  constexpr auto kEnd = static_cast<double>(Limits::max() / kSecond);
  double seconds = 0.0;
  if (!parse(word, seconds) || !(std::abs(seconds) < kEnd)) return std::nullopt;
  return std::llround(seconds * static_cast<double>(kSecond));
}

std::int64_t read_time(TextScanner& text) {
  const std::string_view word = text.word();
  const auto stamp = nanoseconds(word);
  std::int64_t number = 0;
  const bool is_too_large = !stamp && parse(word, number);
  if (!stamp)
    text.reject(fmt::format("a time in seconds is expected, not {}{}", in_quotes(word),
                            is_too_large ? ", which is too large for seconds: divide what is in smaller units" : ""));
  return stamp.value_or(0);
}

bool is_tum_line(TextScanner line) {
  return has_numbers(line, kTumNumbers);
}

bool is_kitti_line(TextScanner line) {
  return has_numbers(line, kKittiNumbers);
}

bool counts_poses(TextScanner text) {
  for (std::size_t counted = 0; text.next_line(); ++counted) {
    if (text.word() != std::to_string(counted)) return false;
  }
  return true;
}

Expected<AnyLog> read_tum_log(TextScanner text, const ReadOptions&) {
  std::vector<Pose<3>> poses;
  std::vector<std::int64_t> stamps;
  const bool has_times = !counts_poses(text);
  const auto read_line = [&] {
    const std::int64_t stamp = read_time(text);
    poses.push_back(read_g2o_pose<3>(text));
    if (has_times) stamps.push_back(stamp);
  };
  return text.each_line(read_line).and_then([&] { return any_log_of(text.source(), poses, stamps); });
}

Expected<AnyLog> read_kitti_log(TextScanner text, const ReadOptions&) {
  std::vector<Pose<3>> poses;
  return text.each_line([&] { poses.push_back(read_rows(text)); }).and_then([&] {
    return any_log_of(text.source(), poses, {});
  });
}

Expected<std::vector<StampedPose>> read_tum(TextScanner text) {
  std::vector<StampedPose> poses;
  std::map<double, Pose<3>> at_time;
  const auto read_line = [&] {
    const double time = text.number();
    const Point<3> translation = text.vector<3>();
    Eigen::Quaterniond q(text.vector<4>());  // x, y, z, w
    const double largest = q.coeffs().cwiseAbs().maxCoeff();
    if (largest == 0.0) text.reject("this quaternion is zero");
    q.coeffs() /= largest;  // Its square could overflow a double.
    poses.push_back({time, {translation, Rotation<3>(q.normalized())}});
    const Pose<3>& first = at_time.emplace(time, poses.back().pose).first->second;
    if (first != poses.back().pose)
      text.reject("a line before has another pose at the same time; keep one, or give a table of poses, which names sessions");
  };
  return text.each_line(read_line).map([&] { return std::move(poses); });
}

}  // namespace mapjoin
