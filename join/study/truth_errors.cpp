// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/study/truth_errors.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// Poses or positions of a map, and the true ones of the same indices.
template <typename T>
struct Pairs {
  std::vector<T> estimate;
  std::vector<T> truth;
};

template <typename Index, typename T>
Pairs<T> known(const Table<Index, T>& estimate, const Table<Index, std::optional<T>>& truth) {
  Pairs<T> known;
  for (const Index index : indices(truth)) {
    if (!truth[index]) continue;
    known.estimate.push_back(estimate[index]);
    known.truth.push_back(*truth[index]);
  }
  return known;
}

/// The rigid motion of the estimate onto the truth; nullopt if the positions leave a rotation free.
template <int Dim>
std::optional<Pose<Dim>> alignment_of(const Pairs<Pose<Dim>>& poses, Pairs<Point<Dim>> points) {
  for (const Pose<Dim>& pose : poses.estimate) points.estimate.push_back(pose.translation);
  for (const Pose<Dim>& pose : poses.truth) points.truth.push_back(pose.translation);
  return rigid_alignment(points.estimate, points.truth);
}

template <int Dim>
ErrorSummary feature_errors(const Pairs<Point<Dim>>& features, const Pose<Dim>& motion) {
  std::vector<double> errors;
  for (std::size_t f = 0; f < features.truth.size(); ++f) {
    errors.push_back((transform(motion, features.estimate[f]) - features.truth[f]).norm());
  }
  return summary_of(errors);
}

/// The errors of poses after a given motion.
template <int Dim>
PoseErrorSummary pose_errors(Pairs<Pose<Dim>> poses, const Pose<Dim>& motion) {
  for (Pose<Dim>& pose : poses.estimate) pose = compose(motion, pose);
  return absolute_trajectory_error(poses.estimate, poses.truth, TrajectoryAlignment::kNone).errors;
}

}  // namespace

template <int Dim>
std::optional<Pose<Dim>> alignment_onto(const Truth<Dim>& truth, const GlobalMap<Dim>& map) {
  return alignment_of(known(map.poses, truth.poses), known(map.features, truth.features));
}

template <int Dim>
AbsoluteErrors absolute_errors(const GlobalMap<Dim>& map, const Truth<Dim>& truth, TrajectoryAlignment alignment) {
  const Pairs<Pose<Dim>> poses = known(map.poses, truth.poses);
  if (poses.truth.empty()) return {};
  const auto by_poses = absolute_trajectory_error(poses.estimate, poses.truth, alignment);
  const Pairs<Point<Dim>> features = known(map.features, truth.features);
  if (alignment != TrajectoryAlignment::kRigid || alignment_of<Dim>(poses, {})) {
    return {by_poses.errors, feature_errors(features, by_poses.alignment), AlignedBy::kPoses};
  }
  const std::optional<Pose<Dim>> motion = alignment_of(poses, features);
  if (!motion) return {{by_poses.errors.translation, {}}, {}, AlignedBy::kTooLittle};
  return {pose_errors(poses, *motion), feature_errors(features, *motion), AlignedBy::kFeatures};
}

template <int Dim>
PoseErrorSummary relative_errors(const GlobalMap<Dim>& map, const Truth<Dim>& truth, PosePairs pairs) {
  const auto is_known = [&](std::size_t p) { return truth.poses[PoseIndex(p)].has_value(); };
  std::erase_if(pairs, [&](const auto& pair) { return !is_known(pair.first) || !is_known(pair.second); });
  std::vector<Pose<Dim>> true_poses;
  for (const auto& pose : truth.poses) true_poses.push_back(pose.value_or(Pose<Dim>{}));
  return relative_pose_error(map.poses, true_poses, pairs);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                          \
  template std::optional<Pose<Dim>> alignment_onto(const Truth<Dim>&, const GlobalMap<Dim>&);             \
  template AbsoluteErrors absolute_errors(const GlobalMap<Dim>&, const Truth<Dim>&, TrajectoryAlignment); \
  template PoseErrorSummary relative_errors(const GlobalMap<Dim>&, const Truth<Dim>&, PosePairs);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
