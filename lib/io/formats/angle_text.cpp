// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <cmath>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/formats/angle_text.hpp>

namespace mapjoin {
namespace {

constexpr double kLeastCosine = 1e-6;

bool is_right_angle(double pitch) {
  return std::abs(std::cos(pitch)) < kLeastCosine;
}

/// ∂(x, y, z, roll, pitch, yaw)/∂step.
Matrix<6> J_numbers_step(double roll, double pitch, double yaw) {
  Matrix<6> J = Matrix<6>::Identity();
  J.bottomRightCorner<3, 3>() = J_vector_euler(roll, pitch, yaw).inverse();
  return J;
}

/// Reads a pose in space, and its roll, pitch and yaw. With weights of these a pitch of a right angle is rejected: there roll
/// and yaw are one rotation.
std::pair<Pose<3>, Vector<3>> read_pose_in_space(TextScanner& text, bool is_weighed) {
  const Vector<3> translation = text.vector<3>();
  const double roll = text.number();
  double pitch = text.number();
  if (is_weighed && is_right_angle(pitch)) {
    text.reject("at a pitch of a right angle weights of roll and yaw say nothing; g2o files weigh the rotation vector");
    pitch = 0.0;
  }
  const double yaw = text.number();
  const Rotation<3> rotation(rotation_from_euler(roll, pitch, yaw).quaternion().normalized());
  return {{translation, rotation}, {roll, pitch, yaw}};
}

/// Reads the next numbers of the line as a pose.
template <int Dim>
Pose<Dim> read_pose_angles(TextScanner& text) {
  if constexpr (Dim == 2) {
    return read_g2o_pose<2>(text);
  } else {
    return read_pose_in_space(text, false).first;
  }
}

/// Reads the next numbers of the line as a pose with weights, and J = ∂numbers/∂step.
template <int Dim>
std::pair<Pose<Dim>, PoseMatrix<Dim>> read_weighed_angles(TextScanner& text) {
  if constexpr (Dim == 2) {
    return {read_g2o_pose<2>(text), PoseMatrix<2>::Identity()};
  } else {
    const auto [pose, angles] = read_pose_in_space(text, true);
    return {pose, J_numbers_step(angles[0], angles[1], angles[2])};
  }
}

PoseVector<2> numbers_of(const Pose<2>& pose) {
  return {pose.translation.x(), pose.translation.y(), pose.rotation.angle()};
}
PoseVector<3> numbers_of(const Pose<3>& pose) {
  return (PoseVector<3>() << pose.translation, euler_from_rotation(pose.rotation)).finished();
}

}  // namespace

template <>
std::optional<PoseAngles<2>> pose_angles(const Pose<2>& pose) {
  return PoseAngles<2>{numbers_of(pose), PoseMatrix<2>::Identity()};
}

template <>
std::optional<PoseAngles<3>> pose_angles(const Pose<3>& pose) {
  const PoseVector<3> numbers = numbers_of(pose);
  if (is_right_angle(numbers[4])) return std::nullopt;
  return PoseAngles<3>{numbers, J_numbers_step(numbers[3], numbers[4], numbers[5])};
}

namespace {

template <int Dim>
constexpr std::string_view kEdge = Dim == 2 ? "EDGE2" : "EDGE3";
template <int Dim>
constexpr std::string_view kVertex = Dim == 2 ? "VERTEX2" : "VERTEX3";

/// Rows and columns of the six weights of an edge in the plane.
constexpr int kOrder[6][2] = {{0, 0}, {0, 1}, {1, 1}, {2, 2}, {0, 2}, {1, 2}};

template <int Dim>
PoseMatrix<Dim> read_toro_weights(TextScanner& text, const TextContext& context) {
  if constexpr (Dim == 3) {
    return read_weights<6>(text, context);
  } else {
    if (is_unweighed(text, context)) return PoseMatrix<2>::Identity();
    PoseMatrix<2> W;
    for (const auto& [row, col] : kOrder) W(row, col) = W(col, row) = text.number();
    return W;
  }
}

template <int Dim>
void put_weights(const PoseMatrix<Dim>& W, TextLine& line) {
  if constexpr (Dim == 3) {
    line.add_symmetric<6>(W);
  } else {
    for (const auto& [row, col] : kOrder) line.add(W(row, col));
  }
}

template <int Dim>
PoseMatrix<Dim> turned(const PoseMatrix<Dim>& W, const PoseMatrix<Dim>& J) {
  if constexpr (Dim == 2) {
    return W;
  } else {
    const PoseMatrix<Dim> JWJ = J.transpose() * W * J;
    return 0.5 * (JWJ + JWJ.transpose());
  }
}

template <int Dim>
MeasuredPose<Dim> read_toro_edge(TextScanner& text, const TextContext& context) {
  const auto [measured, J] = read_weighed_angles<Dim>(text);
  return {measured, turned<Dim>(read_toro_weights<Dim>(text, context), J)};
}

/// Puts a pose with weights on the line, and gives J = ∂step/∂numbers; a fault at a pitch of a right angle.
template <int Dim>
Fault put_weighed_angles(const Pose<Dim>& pose, TextLine& line, PoseMatrix<Dim>& J) {
  const auto angles = pose_angles(pose);
  if (!angles) return kRightAnglePitch;
  line.template add<kPoseDof<Dim>>(angles->numbers);
  J = angles->J_numbers_step.inverse();
  return std::nullopt;
}

template <int Dim>
Fault put_toro_edge(const MeasuredPose<Dim>& edge, TextLine& line) {
  PoseMatrix<Dim> J;
  const Fault fault = put_weighed_angles(edge.measured, line, J);
  if (!fault) put_weights<Dim>(turned<Dim>(edge.information, J), line);
  return fault;
}

template <int Dim>
Fault put_toro_vertex(const Pose<Dim>& pose, TextLine& line) {
  line.add<kPoseDof<Dim>>(numbers_of(pose));
  return std::nullopt;
}

/// True for the tags of equivalences of poses and of GTSAM's bearings and ranges.
bool is_without_place_in_toro(std::string_view tag) {
  return tag == "EQUIV" || tag == "BR";
}

template <int Dim>
constexpr EdgeText<Dim> kToro{
    .name = "TORO's files",
    .comment = Dim == 2 ? "TORO: VERTEX2 i x y phi; EDGE2 i j x y phi, information xx xy yy phiphi xphi yphi"
                        : "TORO: VERTEX3 i x y z roll pitch yaw; EDGE3 i j x y z roll pitch yaw, information row by row",
    .edge_tag = kEdge<Dim>,
    .pose_tag = kVertex<Dim>,
    .weights = Weights::kAngles,
    .is_passed_over = is_without_place_in_toro,
    .read_edge = read_toro_edge<Dim>,
    .read_pose = read_pose_angles<Dim>,
    .put_edge = put_toro_edge<Dim>,
    .put_pose = put_toro_vertex<Dim>,
};

template <int Dim>
constexpr std::string_view kObservationTag = Dim == 2 ? "LANDMARK" : "POINT3";

template <int Size>
Matrix<Size> read_square_root(TextScanner& text, const TextContext& context) {
  return read_weights<Size>(text, context).template triangularView<Eigen::Upper>();
}

/// True if the weights make no square root of full rank, but in TORO's order an information matrix of full rank: TORO's files
/// without vertices look like iSAM's.
bool are_rather_toro(const Matrix<3>& S) {
  if (S.diagonal().array().abs().minCoeff() > 0.0) return false;
  Matrix<3> W;
  for (int k = 0, i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, ++k) W(kOrder[k][0], kOrder[k][1]) = W(kOrder[k][1], kOrder[k][0]) = S(i, j);
  }
  return W.llt().info() == Eigen::ComputationInfo::Success;
}

template <int Size>
Matrix<Size> squared(const Matrix<Size>& S) {
  const Matrix<Size> W = S.transpose() * S;
  return 0.5 * (W + W.transpose());
}

/// The upper triangular S with SᵀS = W; rows that W does not determine are zero.
template <int Size>
Matrix<Size> square_root(Matrix<Size> W) {
  constexpr double kRoundOff = 1e-14;
  Matrix<Size> S = Matrix<Size>::Zero();
  const Vector<Size> diagonal = W.diagonal();
  for (int i = 0; i < Size; ++i) {
    if (!(W(i, i) > kRoundOff * diagonal[i])) continue;
    S.row(i).tail(Size - i) = W.row(i).tail(Size - i) / std::sqrt(W(i, i));
    W -= S.row(i).transpose() * S.row(i);
  }
  return S;
}

template <int Dim>
MeasuredPose<Dim> read_isam_edge(TextScanner& text, const TextContext& context) {
  const auto [measured, J] = read_weighed_angles<Dim>(text);
  const PoseMatrix<Dim> S = read_square_root<kPoseDof<Dim>>(text, context);
  if constexpr (Dim == 2) {
    if (!context.options.from && are_rather_toro(S)) {
      text.reject(
          "these weights are singular as iSAM's square root, and sound as TORO's information matrix; --from toro takes them "
          "so, "
          "--from isam as they stand");
    }
  }
  return {measured, squared<kPoseDof<Dim>>(S * J)};
}

template <int Dim>
MeasuredPoint<Dim> read_isam_point(TextScanner& text, const TextContext& context) {
  const Point<Dim> measured = text.vector<Dim>();
  return {measured, squared<Dim>(read_square_root<Dim>(text, context))};
}

template <int Dim>
Fault put_isam_edge(const MeasuredPose<Dim>& edge, TextLine& line) {
  PoseMatrix<Dim> J;
  const Fault fault = put_weighed_angles(edge.measured, line, J);
  if (!fault) line.template add_symmetric<kPoseDof<Dim>>(square_root<kPoseDof<Dim>>(J.transpose() * edge.information * J));
  return fault;
}

template <int Dim>
Fault put_isam_point(const MeasuredPoint<Dim>& point, TextLine& line) {
  line.template add<Dim>(point.measured).template add_symmetric<Dim>(square_root<Dim>(point.information));
  return std::nullopt;
}

template <int Dim>
constexpr EdgeText<Dim> kIsam{
    .name = "iSAM's files",
    .comment = Dim == 2 ? "iSAM: EDGE2 i j x y phi, square root of the information; LANDMARK i feature x y, likewise"
                        : "iSAM: EDGE3 i j x y z roll pitch yaw, square root of the information; POINT3 i feature x y z",
    .edge_tag = kEdge<Dim>,
    .observation_tag = kObservationTag<Dim>,
    .weights = Weights::kSquareRoot,
    .read_edge = read_isam_edge<Dim>,
    .read_point = read_isam_point<Dim>,
    .put_edge = put_isam_edge<Dim>,
    .put_point = put_isam_point<Dim>,
};

}  // namespace

const EdgeText<2> kToroPlane = kToro<2>;
const EdgeText<3> kToroSpace = kToro<3>;
const EdgeText<2> kIsamPlane = kIsam<2>;
const EdgeText<3> kIsamSpace = kIsam<3>;

}  // namespace mapjoin
