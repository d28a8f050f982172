// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <mapjoin/io/information.hpp>
#include <mapjoin/io/isam.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
constexpr std::string_view kEdge = Dim == 2 ? "EDGE2" : "EDGE3";
template <int Dim>
constexpr std::string_view kObservation = Dim == 2 ? "LANDMARK" : "POINT3";

/// A relative pose with the square root of its information, over translation and rotation vector.
template <int Dim>
struct Motion {
  Pose<Dim> measured;
  PoseMatrix<Dim> S;
};

template <int Size>
Matrix<Size> read_square_root(TextScanner& text) {
  return text.symmetric<Size>().template triangularView<Eigen::Upper>();
}

template <int Dim>
Motion<Dim> read_motion(TextScanner& text);

template <>
Motion<2> read_motion<2>(TextScanner& text) {
  const Vector<3> v = text.vector<3>();
  return {{v.head<2>(), Rotation<2>(v[2])}, read_square_root<3>(text)};
}

/// ∂(roll, pitch, yaw)/∂δ of R Exp(δ) at δ = 0.
Matrix<3> J_angles_rotation(double roll, double pitch) {
  const double s = std::sin(roll);
  const double c = std::cos(roll);
  const double tan_pitch = std::tan(pitch);
  const double cos_pitch = std::cos(pitch);
  return (Matrix<3>() << 1.0, s * tan_pitch, c * tan_pitch, 0.0, c, -s, 0.0, s / cos_pitch, c / cos_pitch).finished();
}

template <>
Motion<3> read_motion<3>(TextScanner& text) {
  constexpr double kLeastCosine = 1e-6;
  const Vector<3> translation = text.vector<3>();
  const double roll = text.number();
  const double pitch = text.number();
  if (std::abs(std::cos(pitch)) < kLeastCosine) text.reject("at a pitch of a right angle roll and yaw are not told apart");
  const double yaw = text.number();
  const Eigen::Quaterniond q = Eigen::AngleAxisd(yaw, Vector<3>::UnitZ()) * Eigen::AngleAxisd(pitch, Vector<3>::UnitY()) *
                               Eigen::AngleAxisd(roll, Vector<3>::UnitX());
  Motion<3> motion{{translation, Rotation<3>(q.normalized())}, read_square_root<6>(text)};
  motion.S.rightCols<3>() *= J_angles_rotation(roll, pitch);
  return motion;
}

template <int Size>
Matrix<Size> squared(const Matrix<Size>& S) {
  const Matrix<Size> W = S.transpose() * S;
  return 0.5 * (W + W.transpose());
}

template <int Dim>
Expected<void> read_line(TextScanner& text, InformationCheck& check, LogBuilder<Dim>& builder) {
  const std::string_view tag = text.word();
  const Place place = text.place();
  const bool is_edge = tag == kEdge<Dim>;
  if (!is_edge && tag != kObservation<Dim>) return text.error(fmt::format("unknown tag {}", in_quotes(tag)));
  const PoseId base{0, text.key()};
  const std::uint64_t target = text.key();
  const auto faulty = [&](const std::string& fault) {
    return text.error(place, fmt::format("the information matrix of edge {}-{} {}", base.key, target, fault));
  };
  if (is_edge) {
    const Motion<Dim> motion = read_motion<Dim>(text);
    if (auto line = text.finish_line(); !line) return line;
    if (base.key == target) return text.error(place, fmt::format("an edge leads from {} to itself", to_string(base)));
    PoseMatrix<Dim> W = squared(motion.S);
    if (const auto fault = check.fault(W)) return faulty(*fault);
    builder.add_pose_edge(base, {0, target}, motion.measured, W);
  } else {
    const Point<Dim> measured = text.vector<Dim>();
    PointMatrix<Dim> W = squared(read_square_root<Dim>(text));
    if (auto line = text.finish_line(); !line) return line;
    if (const auto fault = check.fault(W)) return faulty(*fault);
    builder.add_observation(base, {target}, measured, W);
  }
  return {};
}

template <int Dim>
Expected<AnyLog> read(TextScanner text) {
  InformationCheck check(false);  // A square is semidefinite: only overflow can go wrong.
  LogBuilder<Dim> builder(text.source());
  while (text.next_line()) {
    if (auto line = read_line(text, check, builder); !line) return tl::unexpected(line.error());
  }
  return std::move(builder).finish().map([](Log<Dim>&& log) { return AnyLog(std::move(log)); });
}

}  // namespace

bool is_isam_tag(std::string_view tag) {
  return tag == kEdge<2> || tag == kObservation<2> || tag == kEdge<3> || tag == kObservation<3>;
}

Expected<AnyLog> read_isam(TextScanner text, const ReadOptions&) {
  TextScanner ahead = text;
  const std::string_view first = ahead.next_line() ? ahead.word() : std::string_view();
  return first == kEdge<3> || first == kObservation<3> ? read<3>(std::move(text)) : read<2>(std::move(text));
}

}  // namespace mapjoin
