// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/local_maps/local_map_file.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/lists.hpp>
#include <set>

namespace mapjoin {
namespace {

/// A local map turned to the conventions used inside, before the set gives its features their indices.
template <int Dim>
struct NamedLocalMap {
  std::filesystem::path path;
  std::int64_t number = 0;
  std::vector<FeatureId> features;  ///< In the order of `map.feature_estimates`.
  /// False if the end pose is exactly the start pose (zero motion of zero covariance); then `map` is over the features only.
  bool moves = true;
  LocalMap<Dim> map;  ///< Complete but for its indices.
};

tl::unexpected<Error> row_error(const LocalMapFile& file, Eigen::Index row, const std::string& message) {
  return bad_input(fmt::format("{}: row {} of the state: {}", file.path.string(), row + 1, message));
}

tl::unexpected<Error> file_error(const LocalMapFile& file, const std::string& message) {
  return bad_input(fmt::format("{}: {}", file.path.string(), message));
}

/// The number of rows from `row` on that carry its id.
Eigen::Index rows_of_one_id(const Eigen::MatrixX2d& state, Eigen::Index row) {
  Eigen::Index end = row;
  while (end < state.rows() && state(end, 0) == state(row, 0)) ++end;
  return end - row;
}

Expected<void> check_end_pose(const LocalMapFile& file) {
  const double id = file.state(0, 0);
  if (id == 0.0 || id == -static_cast<double>(file.number)) return {};
  return row_error(file, 0, fmt::format("the end pose's id is {}, not 0 or {}", id, -file.number));
}

template <int Dim>
Expected<std::vector<FeatureId>> feature_ids(const LocalMapFile& file) {
  std::vector<FeatureId> ids;
  std::set<FeatureId> seen;
  for (Eigen::Index row = kPoseDof<Dim>; row < file.state.rows(); row += Dim) {
    const auto id = id_of(file.state(row, 0));
    if (!id) return row_error(file, row, fmt::format("{} is not a feature's id", file.state(row, 0)));
    const FeatureId feature{*id};
    if (const Eigen::Index rows = rows_of_one_id(file.state, row); rows != Dim) {
      return row_error(file, row, fmt::format("{} has {} rows, not {}", to_string(feature), rows, Dim));
    }
    if (!seen.insert(feature).second) {
      return row_error(file, row, fmt::format("{} is there for the second time", to_string(feature)));
    }
    ids.push_back(feature);
  }
  return ids;
}

Expected<void> check_shape(const LocalMapFile& file) {
  const Eigen::Index n = file.state.rows();
  if (file.gaussian.rows() != n || file.gaussian.cols() != n) {
    return file_error(file, fmt::format("the state has {} rows, but its {} is {} x {}", n,
                                        file.is_information ? "information matrix" : "covariance", file.gaussian.rows(),
                                        file.gaussian.cols()));
  }
  for (Eigen::Index row = 0; row < n; ++row) {
    if (!std::isfinite(file.state(row, 1))) return row_error(file, row, "the value is not finite");
  }
  return {};
}

template <int Dim>
Pose<Dim> end_pose(const LocalMapFile& file) {
  const auto value = file.state.col(1);
  if constexpr (Dim == 2) {
    return {value.head<2>(), Rotation<2>(value[2])};
  } else {
    return {value.head<3>(), rotation_from_euler(value[5], value[4], value[3])};
  }
}

/// Turns the Gaussian in space from the angles (a, b, c) = (yaw, pitch, roll) to the step of the rotation: a covariance by J,
/// an information matrix by J⁻ᵀ. In the plane the heading is the rotation's step already.
template <int Dim>
Expected<void> turn_rotation(LocalMapFile& file) {
  if (Dim == 2) return {};
  const Matrix<3> J = J_vector_euler(file.state(5, 1), file.state(4, 1), file.state(3, 1)).rowwise().reverse();
  if (std::abs(J.determinant()) < 1e-9) {
    return row_error(file, 4, "at a pitch of a quarter turn the three angles do not determine each other's error");
  }
  const Matrix<3> T = file.is_information ? Matrix<3>(J.inverse().transpose()) : J;
  file.gaussian.middleRows<3>(3) = (T * file.gaussian.middleRows<3>(3)).eval();
  file.gaussian.middleCols<3>(3) = (file.gaussian.middleCols<3>(3) * T.transpose()).eval();
  return {};
}

Expected<Eigen::MatrixXd> information(const LocalMapFile& file, InformationCheck& check) {
  Eigen::MatrixXd W = file.gaussian;
  const auto fault = file.is_information ? check.fault<Eigen::Dynamic>(W) : check.invert<Eigen::Dynamic>(W);
  if (!fault) return W;
  const char* const what = file.is_information ? "information matrix" : "covariance";
  return file_error(file, fmt::format("the {} of map {} {}", what, file.number, *fault));
}

/// True if the end pose is known to be the start pose: its motion is zero, and so are its rows and columns of the covariance.
template <int Dim>
bool coincides(const LocalMapFile& file) {
  return !file.is_information && file.state.col(1).head<kPoseDof<Dim>>().isZero(0.0) &&
         file.gaussian.topRows<kPoseDof<Dim>>().isZero(0.0) && file.gaussian.leftCols<kPoseDof<Dim>>().isZero(0.0);
}

/// The dimension, 2 or 3, by the number of rows of the end pose.
Expected<int> dimension(const LocalMapFile& file) {
  const Eigen::Index rows = file.state.rows() > 0 ? rows_of_one_id(file.state, 0) : 0;
  // The end pose and the first feature may both have the id 0.
  if (rows == kPoseDof<2> || rows == kPoseDof<2> + 2) return 2;
  if (rows == kPoseDof<3> || rows == kPoseDof<3> + 3) return 3;
  return file_error(file, fmt::format("the state begins with {} rows of one id; an end pose has 3 or 6", rows));
}

/// The map of a file in the conventions used inside. Bad input, naming the file and the row of the state, unless the state is
/// an end pose and features, each once, and the Gaussian is finite, symmetric and, if a covariance, positive definite or, if an
/// information matrix, positive semidefinite (see InformationCheck).
template <int Dim>
Expected<NamedLocalMap<Dim>> named_local_map(LocalMapFile&& file, InformationCheck& check) {
  constexpr int kDof = kPoseDof<Dim>;
  if (auto ok = check_shape(file).and_then([&] { return check_end_pose(file); }); !ok) return tl::unexpected(ok.error());
  auto features = feature_ids<Dim>(file);
  if (!features) return tl::unexpected(features.error());

  NamedLocalMap<Dim> named{file.path, file.number, std::move(*features), !coincides<Dim>(file), {}};
  if (named.moves) {
    if (auto ok = turn_rotation<Dim>(file); !ok) return tl::unexpected(ok.error());
    named.map.pose_estimates.push_back(end_pose<Dim>(file));
  } else {
    const Eigen::Index rest = file.state.rows() - kDof;
    file.gaussian = file.gaussian.bottomRightCorner(rest, rest).eval();
  }
  for (Eigen::Index row = kDof; row < file.state.rows(); row += Dim) {
    named.map.feature_estimates.push_back(file.state.col(1).segment<Dim>(row));
  }
  auto W = information(file, check);
  if (!W) return tl::unexpected(W.error());
  named.map.information = std::move(*W);
  return named;
}

template <int Dim>
using NamedMaps = std::vector<NamedLocalMap<Dim>>;

/// The features' names in ascending order.
template <int Dim>
FeatureIds all_features(const NamedMaps<Dim>& maps) {
  FeatureIds all;
  for (const auto& map : maps) all.insert(all.end(), map.features.begin(), map.features.end());
  make_distinct(all);
  return all;
}

/// Sorts the maps; bad input unless their numbers are 1, 2, ...
template <int Dim>
Expected<void> put_in_order(NamedMaps<Dim>& maps, const std::string& source) {
  std::sort(maps.begin(), maps.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  std::int64_t expected = 1;
  for (std::size_t i = 0; i < maps.size(); ++i, ++expected) {
    if (maps[i].number == expected) continue;
    if (maps[i].number > expected) return bad_input(fmt::format("{}: map {} is missing", source, expected));
    return bad_input(fmt::format("{}: map {} is there twice: {} and {}", source, maps[i].number, maps[i - 1].path.string(),
                                 maps[i].path.string()));
  }
  return {};
}

template <int Dim>
Expected<AnySubmapSet> assemble(NamedMaps<Dim>&& maps, const std::string& source, const MatrixRepairs& repairs) {
  if (auto ok = put_in_order(maps, source); !ok) return tl::unexpected(ok.error());
  SubmapSet<Dim> set;
  set.source = source;
  set.conventions.repairs = repairs;
  set.features = all_features(maps);
  set.poses.push_back(PoseId{0, 0});
  for (NamedLocalMap<Dim>& named : maps) {
    LocalMap<Dim>& map = set.graph.submaps.emplace_back(std::move(named.map));
    map.base = PoseIndex(set.poses.size() - 1);
    if (named.moves) {
      set.poses.push_back(PoseId{0, static_cast<std::uint64_t>(named.number)});
      map.poses.push_back(map.base + 1);
    }
    for (const FeatureId id : named.features) map.features.emplace_back(*find_ascending(set.features, id));
    set.segments.push_back({map.base, PoseIndex(set.poses.size() - 1), true});
  }
  return set;
}

}  // namespace

Expected<AnySubmapSet> read_local_map_set(const std::filesystem::path& folder_or_archive, const ReadOptions& options) {
  const std::string source = folder_or_archive.string();
  InformationCheck check(options.repair_information);
  NamedMaps<2> plane;
  NamedMaps<3> space;
  const auto take = [&](LocalMapFile&& file) -> Expected<void> {
    const auto dim = dimension(file);
    if (!dim) return tl::unexpected(dim.error());
    if (*dim == 2) return named_local_map<2>(std::move(file), check).map([&](auto map) { plane.push_back(std::move(map)); });
    return named_local_map<3>(std::move(file), check).map([&](auto map) { space.push_back(std::move(map)); });
  };
  const auto visited = visit_files(
      folder_or_archive, [](const std::string& name) { return local_map_number(name).has_value(); },
      [&](const std::filesystem::path& path, std::string_view bytes) { return parse_local_map(path, bytes).and_then(take); });
  if (!visited) return tl::unexpected(visited.error());
  if (plane.empty() && space.empty()) {
    return bad_input(fmt::format("{}: holds no localmap_<k>.mat or localmap_<k>.txt", source));
  }
  if (!plane.empty() && !space.empty()) {
    return bad_input(fmt::format("{}: {} is a map of the plane, but {} of space", source, plane.front().path.string(),
                                 space.front().path.string()));
  }
  return plane.empty() ? assemble(std::move(space), source, check.repairs())
                       : assemble(std::move(plane), source, check.repairs());
}

}  // namespace mapjoin
