// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/plotted_map.hpp>
#include <apps/truth_file.hpp>
#include <mapjoin/join/align/alignment.hpp>

namespace mapjoin::apps {
namespace {

/// The covariance of a step of a pose, whose translation is in the frame of the map.
template <int Dim>
void turn(const Matrix<Dim>& R, PoseMatrix<Dim>& P) {
  P.template topRows<Dim>() = R * P.template topRows<Dim>().eval();
  P.template leftCols<Dim>() = P.template leftCols<Dim>().eval() * R.transpose();
}

}  // namespace

template <int Dim>
std::optional<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first) {
  std::vector<Point<Dim>> from, to;
  const auto add_known = [&](const auto& of_truth, const auto& of_first) {
    for (const auto k : indices(of_truth)) {
      if (!of_truth[k]) continue;
      from.push_back(*place_of(of_truth[k]));
      to.push_back(*place_of(of_first[k]));
    }
  };
  add_known(truth.poses, first.poses);
  add_known(truth.features, first.features);
  return rigid_alignment(from, to);
}

template <int Dim>
std::optional<Pose<Dim>> alignment(const GlobalMap<Dim>& map, const GlobalMap<Dim>& first) {
  return alignment(
      Truth<Dim>{by_name(map.pose_ids, map.poses, first.pose_ids), by_name(map.feature_ids, map.features, first.feature_ids)},
      first);
}

template <int Dim>
void move(const Pose<Dim>& frame, PlottedMap<Dim>& plotted) {
  const Matrix<Dim> R = frame.rotation.matrix();
  GlobalMap<Dim>& map = plotted.map;
  for (auto* poses : {&map.poses, &plotted.odometry}) {
    for (Pose<Dim>& pose : *poses) pose = compose(frame, pose);
  }
  for (Point<Dim>& feature : map.features) feature = transform(frame, feature);
  for (JoinStop<Dim>& stop : plotted.stops) stop.state = moved(frame, std::move(stop.state));
  for (PoseMatrix<Dim>& P : map.pose_covariances) turn<Dim>(R, P);
  for (PointMatrix<Dim>& P : map.feature_covariances) P = R * P.eval() * R.transpose();
}

template <int Dim>
void move(const Pose<Dim>& frame, Truth<Dim>& truth) {
  for (auto& pose : truth.poses) {
    if (pose) pose = compose(frame, *pose);
  }
  for (auto& feature : truth.features) {
    if (feature) feature = transform(frame, *feature);
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                             \
  template std::optional<Pose<Dim>> alignment(const GlobalMap<Dim>&, const GlobalMap<Dim>&); \
  template std::optional<Pose<Dim>> alignment(const Truth<Dim>&, const GlobalMap<Dim>&);     \
  template void move(const Pose<Dim>&, PlottedMap<Dim>&);                                    \
  template void move(const Pose<Dim>&, Truth<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
