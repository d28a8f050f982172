// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <mapjoin/io/g2o/measured.hpp>

namespace mapjoin {
namespace {

template <int Dim>
MeasuredPoint<Dim> seen_from(const Pose<Dim>& sensor, const MeasuredPoint<Dim>& seen) {
  return {transform(sensor, seen.measured), turned_to_parent<Dim>(seen.information, sensor.rotation)};
}

/// The pose of the sensor that the next word names.
Pose<3> read_sensor(TextScanner& text, const TextContext& context) {
  const std::uint64_t key = text.key();
  const auto offset = context.offsets.find(key);
  if (offset != context.offsets.end()) return offset->second;
  text.reject(fmt::format("no {} line gives the sensor offset {}", kG2oOffset, key));
  return {};
}

/// Reads a prior of the first `Size` coordinates of a pose; the others have no weight.
template <int Dim, int Size>
MeasuredPose<Dim> read_position(TextScanner& text, const TextContext& context) {
  const auto [measured, W] = read_plain_point<Size>(text, context);
  MeasuredPose<Dim> position{{}, PoseMatrix<Dim>::Zero()};
  position.measured.translation.template head<Size>() = measured;
  position.information.template topLeftCorner<Size, Size>() = W;
  return position;
}

MeasuredPose<3> read_prior_of_sensor(TextScanner& text, const TextContext& context) {
  const Pose<3> sensor = read_sensor(text, context);
  const MeasuredPose<3> seen = read_g2o_edge<3>(text, context);
  if (sensor.translation.isZero(0.0) && sensor.rotation.log().isZero(0.0)) return seen;
  const bool is_rotation_measured =
      Matrix<3>(seen.information.bottomRightCorner<3, 3>()).llt().info() == Eigen::ComputationInfo::Success;
  if (!is_rotation_measured) text.reject("the prior of a sensor away from its pose must measure its rotation");
  PoseMatrix<3> J;
  const Pose<3> robot = compose(seen.measured, inverse(sensor));
  compose(robot, sensor, &J);
  const PoseMatrix<3> W = J.transpose() * seen.information * J;
  return {robot, 0.5 * (W + W.transpose())};
}

}  // namespace

template <int Dim>
MeasuredPose<Dim> read_g2o_edge(TextScanner& text, const TextContext& context) {
  const auto [measured, W] = read_plain_edge<Dim>(text, context);
  return {measured, from_g2o<Dim>(W, measured, context.options)};
}

template <int Dim>
MeasuredPoint<Dim> read_g2o_point(TextScanner& text, const TextContext& context) {
  if constexpr (Dim == 2) {
    return seen_from<2>({}, read_plain_point<2>(text, context));
  } else {
    const Pose<3> sensor = read_sensor(text, context);
    return seen_from<3>(sensor, read_plain_point<3>(text, context));
  }
}

template <int Dim>
MeasuredPose<Dim> read_g2o_pose_prior(const PriorTag& tag, TextScanner& text, const TextContext& context) {
  if (tag.sensor == PriorTag::Sensor::kIgnored) text.key();
  if (tag.kind == PriorTag::Kind::kPlanar) return read_position<Dim, 2>(text, context);
  if (tag.kind == PriorTag::Kind::kPosition) return read_position<Dim, Dim>(text, context);
  if constexpr (Dim == 3) {
    return read_prior_of_sensor(text, context);
  } else {
    return read_g2o_edge<Dim>(text, context);
  }
}

template MeasuredPose<2> read_g2o_edge(TextScanner&, const TextContext&);
template MeasuredPose<3> read_g2o_edge(TextScanner&, const TextContext&);
template MeasuredPoint<2> read_g2o_point(TextScanner&, const TextContext&);
template MeasuredPoint<3> read_g2o_point(TextScanner&, const TextContext&);
template MeasuredPose<2> read_g2o_pose_prior(const PriorTag&, TextScanner&, const TextContext&);
template MeasuredPose<3> read_g2o_pose_prior(const PriorTag&, TextScanner&, const TextContext&);

}  // namespace mapjoin
