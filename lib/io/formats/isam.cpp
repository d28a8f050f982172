// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <mapjoin/io/formats/euler_angles.hpp>
#include <mapjoin/io/formats/isam.hpp>

namespace mapjoin {
namespace {

template <int Dim>
constexpr std::string_view kEdge = Dim == 2 ? "EDGE2" : "EDGE3";
template <int Dim>
constexpr std::string_view kObservation = Dim == 2 ? "LANDMARK" : "POINT3";

template <int Size>
Matrix<Size> read_square_root(TextScanner& text) {
  return text.symmetric<Size>().template triangularView<Eigen::Upper>();
}

template <int Size>
Matrix<Size> squared(const Matrix<Size>& S) {
  const Matrix<Size> W = S.transpose() * S;
  return 0.5 * (W + W.transpose());
}

/// The upper triangle S with SᵀS = W; rows that W does not determine are zero.
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
MeasuredPose<Dim> read_edge(TextScanner& text, InformationCheck&) {
  const auto [measured, J] = read_pose_angles<Dim>(text);
  return {measured, squared<kPoseDof<Dim>>(read_square_root<kPoseDof<Dim>>(text) * J)};
}

template <int Dim>
MeasuredPoint<Dim> read_point(TextScanner& text, InformationCheck&) {
  const Point<Dim> measured = text.vector<Dim>();
  return {measured, squared<Dim>(read_square_root<Dim>(text))};
}

template <int Dim>
Fault put_edge(const MeasuredPose<Dim>& edge, TextLine& line) {
  const auto angles = pose_angles(edge.measured);
  if (!angles) return kRightAnglePitch;
  const PoseMatrix<Dim> J = angles->J_numbers_step.inverse();
  line.template add<kPoseDof<Dim>>(angles->numbers);
  line.template add_symmetric<kPoseDof<Dim>>(square_root<kPoseDof<Dim>>(J.transpose() * edge.information * J));
  return std::nullopt;
}

template <int Dim>
Fault put_point(const MeasuredPoint<Dim>& point, TextLine& line) {
  line.template add<Dim>(point.measured).template add_symmetric<Dim>(square_root<Dim>(point.information));
  return std::nullopt;
}

template <int Dim>
constexpr EdgeText<Dim> kIsam{
    .name = "iSAM's files",
    .comment = Dim == 2 ? "iSAM: EDGE2 i j x y phi, square root of the information; LANDMARK i feature x y, likewise"
                        : "iSAM: EDGE3 i j x y z roll pitch yaw, square root of the information; POINT3 i feature x y z",
    .edge_tag = kEdge<Dim>,
    .observation_tag = kObservation<Dim>,
    .read_edge = read_edge<Dim>,
    .read_point = read_point<Dim>,
    .put_edge = put_edge<Dim>,
    .put_point = put_point<Dim>,
};

}  // namespace

bool is_isam_tag(std::string_view tag) {
  return tag == kEdge<2> || tag == kObservation<2> || tag == kEdge<3> || tag == kObservation<3>;
}

Expected<AnyLog> read_isam(TextScanner text, const ReadOptions& options) {
  TextScanner ahead = text;
  const std::string_view first = ahead.next_line() ? ahead.word() : std::string_view();
  if (first == kEdge<3> || first == kObservation<3>) return read_edge_text(std::move(text), kIsam<3>, options);
  return read_edge_text(std::move(text), kIsam<2>, options);
}

template <int Dim>
Expected<void> write_isam(const Log<Dim>& log, const std::filesystem::path& path) {
  return write_edge_text(log, kIsam<Dim>, path);
}

template Expected<void> write_isam(const Log<2>&, const std::filesystem::path&);
template Expected<void> write_isam(const Log<3>&, const std::filesystem::path&);

}  // namespace mapjoin
