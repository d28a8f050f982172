// SPDX-License-Identifier: BSD-3-Clause
#include <apps/picture/plotted_map.hpp>
#include <mapjoin/join/placement.hpp>
#include <unordered_map>

namespace mapjoin::apps {
namespace {

template <int Dim>
const Point<Dim>& position(const Pose<Dim>& pose) {
  return pose.translation;
}
template <int Dim>
const Point<Dim>& position(const Point<Dim>& feature) {
  return feature;
}

/// The same points in both frames.
template <int Dim>
struct Pairs {
  std::vector<Point<Dim>> from;
  std::vector<Point<Dim>> to;

  template <typename Id, typename Place>
  void add_common(const std::vector<Id>& from_ids, const std::vector<Place>& from_places, const std::vector<Id>& to_ids,
                  const std::vector<Place>& to_places) {
    const auto hash = [](const Id& id) { return std::hash<std::uint64_t>()(id.key); };
    std::unordered_map<Id, std::size_t, decltype(hash)> at(to_ids.size(), hash);
    for (std::size_t k = 0; k < to_ids.size(); ++k) at.emplace(to_ids[k], k);
    for (std::size_t k = 0; k < from_ids.size(); ++k) {
      const auto found = at.find(from_ids[k]);
      if (found == at.end()) continue;
      from.push_back(position<Dim>(from_places[k]));
      to.push_back(position<Dim>(to_places[found->second]));
    }
  }
  template <typename Place>
  void add_known(const std::vector<std::optional<Place>>& from_places, const std::vector<Place>& to_places) {
    for (std::size_t k = 0; k < from_places.size(); ++k) {
      if (!from_places[k]) continue;
      from.push_back(position<Dim>(*from_places[k]));
      to.push_back(position<Dim>(to_places[k]));
    }
  }
};

/// The covariance of a step of a pose, whose translation is in the frame of the map.
template <int Dim>
void turn(const Matrix<Dim>& R, PoseMatrix<Dim>& P) {
  P.template topRows<Dim>() = R * P.template topRows<Dim>().eval();
  P.template leftCols<Dim>() = P.template leftCols<Dim>().eval() * R.transpose();
}

}  // namespace

template <int Dim>
std::optional<Pose<Dim>> alignment(const GlobalMap<Dim>& map, const GlobalMap<Dim>& first) {
  Pairs<Dim> common;
  common.add_common(map.pose_ids, map.poses, first.pose_ids, first.poses);
  common.add_common(map.feature_ids, map.features, first.feature_ids, first.features);
  return rigid_alignment(common.from, common.to);
}

template <int Dim>
std::optional<Pose<Dim>> alignment(const Truth<Dim>& truth, const GlobalMap<Dim>& first) {
  Pairs<Dim> common;
  common.add_known(truth.poses, first.poses);
  common.add_known(truth.features, first.features);
  return rigid_alignment(common.from, common.to);
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
