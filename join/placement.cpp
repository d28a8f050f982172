// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <iterator>
#include <mapjoin/join/placement.hpp>

namespace mapjoin {
namespace {

/// The least spread of points, relative to their largest coordinate and, about their main axis, to their largest spread, that
/// fixes a rotation.
constexpr double kLeastSpread = 1e-6;

template <int Dim>
Eigen::MatrixXd as_columns(const std::vector<Point<Dim>>& points) {
  Eigen::MatrixXd columns(Dim, static_cast<Eigen::Index>(points.size()));
  for (std::size_t k = 0; k < points.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = points[k];
  return columns;
}

/// Whether the points spread in at least Dim - 1 directions, so that a rotation is fixed by them.
template <int Dim>
bool fixes_rotation(const Eigen::MatrixXd& points) {
  const Eigen::MatrixXd centred = points.colwise() - points.rowwise().mean().eval();
  const Vector<Dim> squared = Eigen::JacobiSVD<Matrix<Dim>>(centred * centred.transpose()).singularValues();
  const Vector<Dim> spread = squared.cwiseSqrt();
  const double scale = std::max(1.0, points.cwiseAbs().maxCoeff());
  return spread[0] > kLeastSpread * scale && spread[Dim - 2] > kLeastSpread * spread[0];
}

inline Rotation<2> rotation_of(const Matrix<2>& R) {
  return Rotation<2>(std::atan2(R(1, 0), R(0, 0)));
}
inline Rotation<3> rotation_of(const Matrix<3>& R) {
  return Rotation<3>(R);
}

/// The union of two ascending lists.
std::vector<Index> united(const std::vector<Index>& a, const std::vector<Index>& b) {
  std::vector<Index> both;
  both.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<Index> common(const std::vector<Index>& a, const std::vector<Index>& b) {
  std::vector<Index> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

template <int Dim>
std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to) {
  if (static_cast<int>(from.size()) < Dim) return std::nullopt;
  const auto source = as_columns(from);
  const auto destination = as_columns(to);
  if (!fixes_rotation<Dim>(source) || !fixes_rotation<Dim>(destination)) return std::nullopt;
  const Eigen::MatrixXd T = Eigen::umeyama(source, destination, false);
  return Pose<Dim>{T.topRightCorner<Dim, 1>(), rotation_of(Matrix<Dim>(T.topLeftCorner<Dim, Dim>()))};
}

template <int Dim>
void Ties<Dim>::add_pose(const Pose<Dim>& in_first, const Pose<Dim>& in_second) {
  placements.push_back(compose(in_first, inverse(in_second)));
  add_point(in_first.translation, in_second.translation);
}

template <int Dim>
void Ties<Dim>::add_point(const Point<Dim>& in_first, const Point<Dim>& in_second) {
  first_points.push_back(in_first);
  second_points.push_back(in_second);
}

template <int Dim>
std::vector<Pose<Dim>> Ties<Dim>::candidates() const {
  std::vector<Pose<Dim>> tries;
  // Placements from single poses: the first, the middle and the last stand for all.
  const std::size_t count = placements.size();
  std::size_t last = 0;
  for (const std::size_t k : {std::size_t{0}, count / 2, count - 1}) {
    if (k < count && (tries.empty() || k > last)) tries.push_back(placements[k]);
    last = k;
  }
  if (const auto aligned = rigid_alignment(second_points, first_points)) tries.push_back(*aligned);
  return tries;
}

template <int Dim>
Ties<Dim> ties_between(const Piece<Dim>& a, const Piece<Dim>& b, const std::vector<const PoseObservation<Dim>*>& closures) {
  Ties<Dim> ties;
  for (const Index pose : common(a.poses, b.poses)) ties.add_pose(pose_in(a, pose), pose_in(b, pose));
  for (const auto* closure : closures) {
    if (holds(a.poses, closure->base) && holds(b.poses, closure->target)) {
      ties.add_pose(compose(pose_in(a, closure->base), closure->measured), pose_in(b, closure->target));
    } else if (holds(b.poses, closure->base) && holds(a.poses, closure->target)) {
      ties.add_pose(pose_in(a, closure->target), compose(pose_in(b, closure->base), closure->measured));
    }
  }
  for (const Index feature : common(a.features, b.features)) ties.add_point(feature_in(a, feature), feature_in(b, feature));
  return ties;
}

template <int Dim>
Piece<Dim> merged(const Piece<Dim>& a, const Piece<Dim>& b, const Pose<Dim>& placement) {
  Piece<Dim> both;
  both.poses = united(a.poses, b.poses);
  both.features = united(a.features, b.features);
  both.state.poses.reserve(both.poses.size());
  both.state.features.reserve(both.features.size());
  for (const Index pose : both.poses) {
    both.state.poses.push_back(holds(a.poses, pose) ? pose_in(a, pose) : compose(placement, pose_in(b, pose)));
  }
  for (const Index feature : both.features) {
    both.state.features.push_back(holds(a.features, feature) ? feature_in(a, feature)
                                                             : transform(placement, feature_in(b, feature)));
  }
  for (const Piece<Dim>* piece : {&a, &b}) {
    append(both.maps, piece->maps);
    append(both.pose_observations, piece->pose_observations);
    append(both.feature_observations, piece->feature_observations);
  }
  return both;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                          \
  template std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>&, const std::vector<Point<Dim>>&);      \
  template struct Ties<Dim>;                                                                                              \
  template Ties<Dim> ties_between(const Piece<Dim>&, const Piece<Dim>&, const std::vector<const PoseObservation<Dim>*>&); \
  template Piece<Dim> merged(const Piece<Dim>&, const Piece<Dim>&, const Pose<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
