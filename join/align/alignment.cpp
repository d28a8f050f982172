// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <iterator>
#include <limits>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/simulate/random_stream.hpp>

namespace mapjoin {
namespace {

/// The least spread of points that fixes a rotation: in metres, relative to their largest coordinate, whose digits end there,
/// and, about their main axis, to their largest spread.
constexpr double kLeastSpread = 1e-6;
constexpr double kLeastShareOfCoordinates = 1e-10;

/// Number of samples for a least median of squares: if half of the points are wrong, all miss two right ones with a probability
/// of 3e-38, three with 4e-18.
constexpr int kSamples = 300;

/// The number of directions in which points spread, Dim at most; Dim - 1 fix a rotation.
template <int Dim>
int spread_directions(const std::vector<Point<Dim>>& points) {
  Point<Dim> mean = Point<Dim>::Zero();
  double largest = 0.0;
  for (const auto& point : points) {
    mean += point;
    largest = std::max(largest, point.cwiseAbs().maxCoeff());
  }
  mean /= static_cast<double>(points.size());
  Matrix<Dim> scatter = Matrix<Dim>::Zero();
  for (const auto& point : points) scatter.noalias() += (point - mean) * (point - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Matrix<Dim>> axes;
  if constexpr (Dim == 2) {
    axes.computeDirect(scatter, Eigen::EigenvaluesOnly);
  } else {
    axes.compute(scatter, Eigen::EigenvaluesOnly);  // in 3D the direct method loses half the digits
  }
  const Vector<Dim> spread = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending
  if (!(spread[Dim - 1] > std::max(kLeastSpread, kLeastShareOfCoordinates * largest))) return 0;
  return static_cast<int>((spread.array() > kLeastSpread * spread[Dim - 1]).count());
}

/// The motion of points onto others where a line in space leaves the roll free. What is added to their cross-covariance asks
/// for the least turn; the vertical counts double, so that what leads back is turned about it, not upside down.
Pose<3> aligned_line(const std::vector<Point<3>>& from, const std::vector<Point<3>>& to) {
  using Columns = Eigen::Map<const Eigen::Matrix3Xd>;
  const Columns first(from.front().data(), 3, std::ssize(from)), second(to.front().data(), 3, std::ssize(to));
  const Point<3> first_mean = first.rowwise().mean(), second_mean = second.rowwise().mean();
  Matrix<3> C = (second.colwise() - second_mean) * (first.colwise() - first_mean).transpose();
  C.diagonal() += kLeastSpread * C.norm() * Point<3>(1.0, 1.0, 2.0);
  const Rotation<3> rotation = nearest_rotation(C);
  return {second_mean - rotation.matrix() * first_mean, rotation};
}

/// Calls f(place in a, place in b) for every index that two ascending lists share. Linear in the range that they have in
/// common.
template <typename Index, typename F>
void for_each_common(const Table<Index, Index>& a, const Table<Index, Index>& b, F&& f) {
  if (a.empty() || b.empty()) return;
  Index i = place_of(a, b.front());
  Index j = place_of(b, a.front());
  while (i < indices(a).last && j < indices(b).last) {
    if (a[i] == b[j])
      f(i++, j++);
    else if (a[i] < b[j])
      ++i;
    else
      ++j;
  }
}

/// The union of two ascending lists with their values; those of `b` are moved, those of `a` take precedence.
template <typename Index, typename T, typename Moved>
void unite(const Table<Index, Index>& a, const Table<Index, T>& a_values, const Table<Index, Index>& b,
           const Table<Index, T>& b_values, const Moved& moved, Table<Index, Index>& both, Table<Index, T>& values) {
  both.reserve(a.size() + b.size());
  values.reserve(a.size() + b.size());
  const Index a_end = indices(a).last, b_end = indices(b).last;
  for (Index i, j; i < a_end || j < b_end;) {
    if (j == b_end || (i < a_end && a[i] <= b[j])) {
      if (j < b_end && a[i] == b[j]) ++j;
      both.push_back(a[i]);
      values.push_back(a_values[i++]);
    } else {
      both.push_back(b[j]);
      values.push_back(moved(b_values[j++]));
    }
  }
}

}  // namespace

template <int Dim>
std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to) {
  if (static_cast<int>(from.size()) < Dim) return std::nullopt;
  if (std::min(spread_directions<Dim>(from), spread_directions<Dim>(to)) < Dim - 1) return std::nullopt;
  return align<Dim>(from, to);
}

template <int Dim>
std::optional<Pose<Dim>> least_turning_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to) {
  auto aligned = rigid_alignment<Dim>(from, to);
  if constexpr (Dim == 3) {
    const bool are_lines = !from.empty() && std::min(spread_directions<Dim>(from), spread_directions<Dim>(to)) > 0;
    if (!aligned && are_lines) aligned = aligned_line(from, to);
  }
  return aligned;
}

template <int Dim>
std::optional<Pose<Dim>> least_median_alignment(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to) {
  RandomStream random(1, 0);
  std::optional<Pose<Dim>> best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kSamples; ++k) {
    std::vector<Point<Dim>> some_from, some_to;
    for (int i = 0; i < Dim; ++i) {
      const auto chosen = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(from.size())));
      some_from.push_back(from[chosen]);
      some_to.push_back(to[chosen]);
    }
    const auto alignment = rigid_alignment<Dim>(some_from, some_to);
    if (!alignment) continue;
    std::vector<double> distances;
    for (std::size_t f = 0; f < from.size(); ++f) distances.push_back((transform(*alignment, from[f]) - to[f]).squaredNorm());
    const double middle = median(std::move(distances));
    if (middle >= least) continue;
    least = middle;
    best = alignment;
  }
  return best;
}

template <int Dim>
void Correspondences<Dim>::add_pose(const Pose<Dim>& in_first, const Pose<Dim>& in_second) {
  alignments.push_back(compose(in_first, inverse(in_second)));
  add_point(in_first.translation, in_second.translation);
}

template <int Dim>
void Correspondences<Dim>::add_closure(const PoseFactor<Dim>& closure, const Pose<Dim>& in_first, const Pose<Dim>& in_second) {
  if (!measures_position(closure)) {
    if (measures_rotation(closure)) turns.push_back(compose(in_first, inverse(in_second)));
    return;
  }
  if (measures_rotation(closure)) return add_pose(in_first, in_second);
  add_point(in_first.translation, in_second.translation);
}

template <int Dim>
void Correspondences<Dim>::add_point(const Point<Dim>& in_first, const Point<Dim>& in_second) {
  first_points.push_back(in_first);
  second_points.push_back(in_second);
}

template <int Dim>
std::vector<Pose<Dim>> Correspondences<Dim>::candidates() const {
  std::vector<Pose<Dim>> tries;
  // Placements from single poses: the first, the middle and the last stand for all.
  const std::size_t count = alignments.size();
  std::size_t last = 0;
  for (const std::size_t k : {std::size_t{0}, count / 2, count - 1}) {
    if (k < count && (tries.empty() || k > last)) tries.push_back(alignments[k]);
    last = k;
  }
  if (const auto aligned = rigid_alignment(second_points, first_points)) tries.push_back(*aligned);
  if (tries.empty() && !turns.empty()) tries.push_back(turns.front());
  return tries;
}

template <int Dim>
Correspondences<Dim> correspondences_between(const PartialMap<Dim>& a, const PartialMap<Dim>& b,
                                             const std::vector<const PoseFactor<Dim>*>& closures) {
  Correspondences<Dim> correspondences;
  correspondences.first_points.reserve(std::min(a.features.size(), b.features.size()) + 1);
  correspondences.second_points.reserve(correspondences.first_points.capacity());
  for_each_common(a.poses, b.poses,
                  [&](PoseIndex i, PoseIndex j) { correspondences.add_pose(a.state.poses[i], b.state.poses[j]); });
  for (const auto* closure : closures) {
    const auto* base = find_pose(a, closure->base);
    const auto* target = find_pose(b, closure->target);
    if (base && target) {
      correspondences.add_closure(*closure, compose(*base, closure->measured), *target);
      continue;
    }
    base = find_pose(b, closure->base);
    target = find_pose(a, closure->target);
    if (base && target) correspondences.add_closure(*closure, *target, compose(*base, closure->measured));
  }
  for_each_common(a.features, b.features,
                  [&](FeatureIndex i, FeatureIndex j) { correspondences.add_point(a.state.features[i], b.state.features[j]); });
  return correspondences;
}

template <int Dim>
PartialMap<Dim> merged(const PartialMap<Dim>& a, const PartialMap<Dim>& b, const Pose<Dim>& alignment) {
  PartialMap<Dim> both;
  unite(
      a.poses, a.state.poses, b.poses, b.state.poses, [&](const Pose<Dim>& pose) { return compose(alignment, pose); },
      both.poses, both.state.poses);
  unite(
      a.features, a.state.features, b.features, b.state.features,
      [&](const Point<Dim>& point) { return transform(alignment, point); }, both.features, both.state.features);
  both.factors = a.factors;
  append(both.factors.pose_factors, b.factors.pose_factors);
  append(both.factors.feature_factors, b.factors.feature_factors);
  append(both.factors.submaps, b.factors.submaps);
  return both;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                             \
  template std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>&, const std::vector<Point<Dim>>&);         \
  template std::optional<Pose<Dim>> least_median_alignment(const std::vector<Point<Dim>>&, const std::vector<Point<Dim>>&);  \
  template std::optional<Pose<Dim>> least_turning_alignment(const std::vector<Point<Dim>>&, const std::vector<Point<Dim>>&); \
  template struct Correspondences<Dim>;                                                                                      \
  template Correspondences<Dim> correspondences_between(const PartialMap<Dim>&, const PartialMap<Dim>&,                      \
                                                        const std::vector<const PoseFactor<Dim>*>&);                         \
  template PartialMap<Dim> merged(const PartialMap<Dim>&, const PartialMap<Dim>&, const Pose<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
