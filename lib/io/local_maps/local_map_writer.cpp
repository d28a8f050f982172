// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/angle_text.hpp>
#include <mapjoin/io/formats/edge_text.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>

namespace mapjoin {
namespace {

/// A local map in the rows of its file.
struct Rows {
  std::int64_t number = 0;
  Eigen::Index pose_rows = 0;  ///< Rows of the end pose, at the top; zeros if the map does not move.
  Eigen::VectorXd ids;         ///< Id of each row; 0 in those of the end pose.
  Eigen::VectorXd values;
  Eigen::MatrixXd information;  ///< Over all rows, or over the features' if the map does not move.
};

/// Puts the numbers of the end pose; in the plane its weights stay as they are.
void put_end_pose(const Pose<2>& end, Rows& rows) {
  rows.values.head<3>() << end.translation, end.rotation.angle();
}
/// Puts the numbers of the end pose, with yaw, pitch, roll as in the file, and turns the weights of its step to them.
void put_end_pose(const Pose<3>& end, Rows& rows) {
  const Vector<3> angles = euler_from_rotation(end.rotation);
  rows.values.head<6>() << end.translation, angles.reverse();
  const Matrix<3> J = J_vector_euler(angles[0], angles[1], angles[2]).rowwise().reverse();
  rows.information.middleRows<3>(3) = (J.transpose() * rows.information.middleRows<3>(3)).eval();
  rows.information.middleCols<3>(3) = (rows.information.middleCols<3>(3) * J).eval();
}

template <int Dim>
Rows rows_of(const LocalMap<Dim>& map, std::int64_t number, const FeatureIds& features) {
  constexpr Eigen::Index kPoseRows = kPoseDof<Dim>;
  const Eigen::Index n = kPoseRows + Dim * static_cast<Eigen::Index>(map.features.size());
  Rows rows{number, kPoseRows, Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), map.information};
  if (!map.poses.empty()) put_end_pose(map.pose_estimates.front(), rows);
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    const Eigen::Index row = kPoseRows + Dim * static_cast<Eigen::Index>(f);
    const auto id = static_cast<double>(features[map.features[f]].key);
    rows.ids.segment<Dim>(row).setConstant(id);
    rows.values.segment<Dim>(row) = map.feature_estimates[f];
  }
  return rows;
}

/// The fault of a map, worded to follow its number; nullopt if none. The map must start from the pose `at`.
template <int Dim>
Fault fault_of(const LocalMap<Dim>& map, PoseIndex at, const FeatureIds& features, LocalMapFormat format) {
  constexpr auto kEnd = static_cast<std::uint64_t>(kDoubleIdEnd);
  if (map.base != at) return "does not start where the one before it ends";
  if (map.poses.size() > 1) return "keeps inner poses, which closures or other maps mention";
  const bool is_large =
      std::any_of(map.features.begin(), map.features.end(), [&](FeatureIndex f) { return features[f].key >= kEnd; });
  if (is_large) return "has a feature whose id is 2^53 or more";
  if (map.poses.empty() && (Dim == 3 || format == LocalMapFormat::kText)) return "does not move";
  if (!map.poses.empty() && !pose_angles(map.pose_estimates.front())) return kRightAnglePitch;
  return std::nullopt;
}

Expected<void> write_text(const Rows& rows, const std::filesystem::path& path) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  TextLine line(' ');
  line.add(rows.number - 1).write_to(*file);
  line.add(rows.values.size()).write_to(*file);
  for (Eigen::Index row = 0; row < rows.values.size(); ++row) {
    line.add(row < rows.pose_rows ? -rows.number : static_cast<std::int64_t>(rows.ids[row]));
    line.add(rows.values[row]).write_to(*file);
  }
  for (Eigen::Index row = 0; row < rows.information.rows(); ++row) {
    for (Eigen::Index col = 0; col < rows.information.cols(); ++col) line.add(rows.information(row, col));
    line.write_to(*file);
  }
  return file->commit_unsynced();
}

/// The variables of a MAT file: in the plane with a covariance, zero for an end pose that is the start pose; in space with an
/// information matrix. Nullopt if the covariance does not exist.
template <int Dim>
std::optional<std::vector<MatVariable>> mat_of(const Rows& rows) {
  const Eigen::Index n = rows.values.size();
  Eigen::MatrixXd state(n, 2);
  state << rows.ids, rows.values;
  if (Dim == 3) {
    const Eigen::MatrixXd start = Eigen::MatrixXd::Constant(1, 1, static_cast<double>(rows.number - 1));
    return std::vector<MatVariable>{{"st", state}, {"I", rows.information}, {"Ref", start}};
  }
  Eigen::MatrixXd covariance;
  if (covariance_of<Eigen::Dynamic>(rows.information, covariance)) return std::nullopt;
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  P.bottomRightCorner(covariance.rows(), covariance.cols()) = covariance;
  return std::vector<MatVariable>{{"localmap_st", state}, {"localmap_P", P}};
}

}  // namespace

template <int Dim>
Expected<std::vector<std::string>> write_local_maps(const std::vector<LocalMap<Dim>>& maps, const FeatureIds& features,
                                                    LocalMapFormat format, const std::filesystem::path& folder) {
  const bool is_text = format == LocalMapFormat::kText;
  std::vector<std::string> names;
  PoseIndex at = maps.empty() ? PoseIndex() : maps.front().base;
  for (const LocalMap<Dim>& map : maps) {
    const auto number = static_cast<std::int64_t>(names.size()) + 1;
    const auto refused = [&](const std::string& fault) {
      return tl::unexpected(
          Error{ErrorKind::kUsage, fmt::format("local map {} {}, which such files cannot say", number, fault)});
    };
    if (const Fault fault = fault_of(map, at, features, format)) return refused(*fault);
    if (!map.poses.empty()) at = map.poses.front();
    const Rows rows = rows_of(map, number, features);
    names.push_back(fmt::format("localmap_{}.{}", number, is_text ? "txt" : "mat"));
    const std::filesystem::path path = folder / names.back();
    if (is_text) {
      if (auto written = write_text(rows, path); !written) return tl::unexpected(written.error());
    } else {
      const auto variables = mat_of<Dim>(rows);
      if (!variables) return refused("has a singular information matrix, and so no covariance");
      const auto written = mat_bytes(*variables, path.string()).and_then([&](const std::string& bytes) {
        return write_file_unsynced(path, bytes);
      });
      if (!written) return tl::unexpected(written.error());
    }
  }
  return names;
}

template Expected<std::vector<std::string>> write_local_maps(const std::vector<LocalMap<2>>&, const FeatureIds&, LocalMapFormat,
                                                             const std::filesystem::path&);
template Expected<std::vector<std::string>> write_local_maps(const std::vector<LocalMap<3>>&, const FeatureIds&, LocalMapFormat,
                                                             const std::filesystem::path&);

}  // namespace mapjoin
