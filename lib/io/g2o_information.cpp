// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/g2o_information.hpp>

namespace mapjoin {

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
