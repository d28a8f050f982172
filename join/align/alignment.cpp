// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin {
namespace {

/// The least spread of points that fixes a rotation, relative to their largest coordinate, or to 1 m if that is less, and,
/// about their main axis, to their largest spread.
constexpr double kLeastSpread = 1e-6;

/// True if the points spread in at least Dim - 1 directions, and so fix a rotation.
template <int Dim>
bool fixes_rotation(const std::vector<Point<Dim>>& points) {
  Point<Dim> mean = Point<Dim>::Zero();
  double scale = 1.0;
  for (const auto& point : points) {
    mean += point;
    scale = std::max(scale, point.cwiseAbs().maxCoeff());
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
  const Vector<Dim> spread = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // ascending: [1] is the least of Dim - 1
  return spread[Dim - 1] > kLeastSpread * scale && spread[1] > kLeastSpread * spread[Dim - 1];
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
  if (!fixes_rotation<Dim>(from) || !fixes_rotation<Dim>(to)) return std::nullopt;
  return align<Dim>(from, to);
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

#define MAPJOIN_INSTANTIATE(Dim)                                                                                     \
  template std::optional<Pose<Dim>> rigid_alignment(const std::vector<Point<Dim>>&, const std::vector<Point<Dim>>&); \
  template struct Correspondences<Dim>;                                                                              \
  template Correspondences<Dim> correspondences_between(const PartialMap<Dim>&, const PartialMap<Dim>&,              \
                                                        const std::vector<const PoseFactor<Dim>*>&);                 \
  template PartialMap<Dim> merged(const PartialMap<Dim>&, const PartialMap<Dim>&, const Pose<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
