// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/formats/euler_angles.hpp>
#include <mapjoin/io/formats/toro.hpp>

namespace mapjoin {
namespace {

template <int Dim>
constexpr std::string_view kVertex = Dim == 2 ? "VERTEX2" : "VERTEX3";
template <int Dim>
constexpr std::string_view kEdge = Dim == 2 ? "EDGE2" : "EDGE3";

/// Rows and columns of the six weights of an edge in the plane.
constexpr int kOrder[6][2] = {{0, 0}, {0, 1}, {1, 1}, {2, 2}, {0, 2}, {1, 2}};

PoseMatrix<2> read_weights(TextScanner& text, std::integral_constant<int, 2>) {
  PoseMatrix<2> W;
  for (const auto& [row, col] : kOrder) W(row, col) = W(col, row) = text.number();
  return W;
}
PoseMatrix<3> read_weights(TextScanner& text, std::integral_constant<int, 3>) {
  return text.symmetric<6>();
}

void put_weights(const PoseMatrix<2>& W, TextLine& line) {
  for (const auto& [row, col] : kOrder) line.add(W(row, col));
}
void put_weights(const PoseMatrix<3>& W, TextLine& line) {
  line.add_symmetric<6>(W);
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
MeasuredPose<Dim> read_edge(TextScanner& text, InformationCheck&) {
  const auto [measured, J] = read_pose_angles<Dim>(text);
  return {measured, turned<Dim>(read_weights(text, std::integral_constant<int, Dim>()), J)};
}

template <int Dim>
Pose<Dim> read_vertex(TextScanner& text) {
  return read_pose_angles<Dim>(text).first;
}

template <int Dim>
Fault put_edge(const MeasuredPose<Dim>& edge, TextLine& line) {
  const auto angles = pose_angles(edge.measured);
  if (!angles) return kRightAnglePitch;
  line.template add<kPoseDof<Dim>>(angles->numbers);
  put_weights(turned<Dim>(edge.information, angles->J_numbers_step.inverse()), line);
  return std::nullopt;
}

template <int Dim>
Fault put_vertex(const Pose<Dim>& pose, TextLine& line) {
  const auto angles = pose_angles(pose);
  if (!angles) return kRightAnglePitch;
  line.template add<kPoseDof<Dim>>(angles->numbers);
  return std::nullopt;
}

template <int Dim>
constexpr EdgeText<Dim> kToro{
    .name = "TORO's files",
    .comment = Dim == 2 ? "TORO: VERTEX2 i x y phi; EDGE2 i j x y phi, information xx xy yy phiphi xphi yphi"
                        : "TORO: VERTEX3 i x y z roll pitch yaw; EDGE3 i j x y z roll pitch yaw, information row by row",
    .edge_tag = kEdge<Dim>,
    .pose_tag = kVertex<Dim>,
    .read_edge = read_edge<Dim>,
    .read_pose = read_vertex<Dim>,
    .put_edge = put_edge<Dim>,
    .put_pose = put_vertex<Dim>,
};

}  // namespace

bool is_toro_vertex_tag(std::string_view tag) {
  return tag == kVertex<2> || tag == kVertex<3>;
}

Expected<AnyLog> read_toro(TextScanner text, const ReadOptions& options) {
  TextScanner ahead = text;
  const std::string_view first = ahead.next_line() ? ahead.word() : std::string_view();
  if (first == kVertex<3> || first == kEdge<3>) return read_edge_text(std::move(text), kToro<3>, options);
  return read_edge_text(std::move(text), kToro<2>, options);
}

template <int Dim>
Expected<void> write_toro(const Log<Dim>& log, const std::filesystem::path& path) {
  return write_edge_text(log, kToro<Dim>, path);
}

template Expected<void> write_toro(const Log<2>&, const std::filesystem::path&);
template Expected<void> write_toro(const Log<3>&, const std::filesystem::path&);

}  // namespace mapjoin
