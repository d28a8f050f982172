// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <mapjoin/io/g2o/fields.hpp>

namespace mapjoin {

template <>
Pose<2> read_g2o_pose<2>(TextScanner& text) {
  const Vector<3> v = text.vector<3>();
  return {v.head<2>(), Rotation<2>(v[2])};
}

// A quaternion of unit length to round-off is kept as it is, so that what was written reads back as the same bits.
template <>
Pose<3> read_g2o_pose<3>(TextScanner& text) {
  constexpr double kRoundOff = 1e-14;
  const Vector<3> translation = text.vector<3>();
  Eigen::Quaterniond q(text.vector<4>());
  const double squared = q.squaredNorm();
  if (squared < 0.25 || squared > 4.0) text.reject("the four numbers up to here are not a unit quaternion");
  if (std::abs(squared - 1.0) > kRoundOff) q.normalize();
  return {translation, Rotation<3>(q)};
}

Expected<G2oOffsets> read_g2o_offsets(TextScanner text) {
  G2oOffsets offsets;
  while (text.next_line()) {
    if (text.word() != kG2oOffset) continue;
    const std::uint64_t key = text.key();
    const Place place = text.place();
    const Pose<3> robot_sensor = read_g2o_pose<3>(text);
    if (auto line = text.finish_line(); !line) return tl::unexpected(line.error());
    if (!offsets.emplace(key, robot_sensor).second) {
      return text.error(
          place, fmt::format("sensor offset {} is given a second time; if these are two logs, give them as two files", key));
    }
  }
  return offsets;
}

template <int Dim>
PoseMatrix<Dim> from_g2o(const PoseMatrix<Dim>& W, const Pose<Dim>& measured, const ReadOptions& options) {
  constexpr int kRot = kRotationDof<Dim>;
  PoseMatrix<Dim> turned = W;
  if (options.pose_error == PoseError::kG2o) {
    const PointMatrix<Dim> R = measured.rotation.matrix();
    const Matrix<Dim, kRot> cross = R * W.template topRightCorner<Dim, kRot>();
    turned.template topLeftCorner<Dim, Dim>() = turned_to_parent<Dim>(W.template topLeftCorner<Dim, Dim>(), measured.rotation);
    turned.template topRightCorner<Dim, kRot>() = cross;
    turned.template bottomLeftCorner<kRot, Dim>() = cross.transpose();
  }
  if (Dim == 3 && options.rotation_information == RotationInformation::kQuaternion) {
    turned.template bottomRows<kRot>() *= 0.5;
    turned.template rightCols<kRot>() *= 0.5;
  }
  return turned;
}

tl::unexpected<Error> not_in_g2o(const std::string& file) {
  return tl::unexpected(Error{ErrorKind::kUsage, file + ": is not in g2o, for which --g2o-error and --rotation-information "
                                                        "are; leave them out"});
}

template <int Dim>
PointMatrix<Dim> turned_to_parent(const PointMatrix<Dim>& W, const Rotation<Dim>& rotation) {
  const PointMatrix<Dim> R = rotation.matrix();
  const PointMatrix<Dim> turned = R * W * R.transpose();
  return 0.5 * turned + 0.5 * turned.transpose();
}

template PoseMatrix<2> from_g2o<2>(const PoseMatrix<2>&, const Pose<2>&, const ReadOptions&);
template PoseMatrix<3> from_g2o<3>(const PoseMatrix<3>&, const Pose<3>&, const ReadOptions&);
template PointMatrix<2> turned_to_parent<2>(const PointMatrix<2>&, const Rotation<2>&);
template PointMatrix<3> turned_to_parent<3>(const PointMatrix<3>&, const Rotation<3>&);

}  // namespace mapjoin
