// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/geometry/upper_triangle.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/formats/trajectory.hpp>
#include <string>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

Eigen::RowVectorXd row_of(const Pose<2>& pose) {
  return Eigen::RowVector3d(pose.translation.x(), pose.translation.y(), pose.rotation.angle());
}
Eigen::RowVectorXd row_of(const Pose<3>& pose) {
  return (Eigen::Matrix<double, 1, 7>() << pose.translation.transpose(), pose.rotation.quaternion().coeffs().transpose())
      .finished();
}

template <typename Index, typename Covariance>
Eigen::MatrixXd triangles(const Table<Index, Covariance>& covariances) {
  constexpr int kSize = Covariance::RowsAtCompileTime;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(covariances.size()), kSize * (kSize + 1) / 2);
  for (const Index k : indices(covariances)) {
    Eigen::Index column = 0;
    each_of_upper_triangle(covariances[k], [&](double entry) { rows(k.value, column++) = entry; });
  }
  return rows;
}

/// kUsage if a double does not hold one of the ids.
template <typename Ids>
Expected<void> check_ids(const Ids& ids) {
  const auto large =
      std::ranges::find_if(ids, [](const auto& id) { return id.key >= static_cast<std::uint64_t>(kDoubleIdEnd); });
  if (large == ids.end()) return {};
  return tl::unexpected(
      Error{ErrorKind::kUsage, to_string(*large) + " has an id of 2^53 or more, which a MAT file cannot say; .csv can"});
}

}  // namespace

Expected<void> check_mat_ids(const PoseIds& poses, const FeatureIds& features) {
  return check_ids(poses).and_then([&] { return check_ids(features); });
}

template <int Dim>
Expected<void> write_mat_map(const GlobalMap<Dim>& map, const std::filesystem::path& path) {
  demand_whole(map);
  if (auto fit = check_mat_ids(map.pose_ids, map.feature_ids); !fit) return fit;
  Eigen::MatrixXd poses(static_cast<Eigen::Index>(map.poses.size()), 2 + row_of(Pose<Dim>{}).size());
  for (const PoseIndex p : indices(map.poses)) {
    const PoseId& id = map.pose_ids[p];
    poses.row(p.value) << static_cast<double>(id.session), static_cast<double>(id.key), row_of(map.poses[p]);
  }
  Eigen::MatrixXd features(static_cast<Eigen::Index>(map.features.size()), 1 + Dim);
  for (const FeatureIndex f : indices(map.features)) {
    features.row(f.value) << static_cast<double>(map.feature_ids[f].key), map.features[f].transpose();
  }
  std::vector<MatVariable> variables = {{"poses", poses}, {"features", features}};
  if (!map.stamps_ns.empty()) {
    Eigen::VectorXd stamps(poses.rows());
    for (const PoseIndex p : indices(map.stamps_ns)) stamps[p.value] = in_seconds(map.stamps_ns[p]);
    variables.emplace_back("stamps", stamps);
  }
  if (!map.pose_covariances.empty()) {
    variables.emplace_back("pose_covariances", triangles(map.pose_covariances));
    variables.emplace_back("feature_covariances", triangles(map.feature_covariances));
  }
  return mat_bytes(variables, path.string()).and_then([&](const std::string& bytes) { return write_file(path, bytes); });
}

template Expected<void> write_mat_map(const GlobalMap<2>&, const std::filesystem::path&);
template Expected<void> write_mat_map(const GlobalMap<3>&, const std::filesystem::path&);

}  // namespace mapjoin
