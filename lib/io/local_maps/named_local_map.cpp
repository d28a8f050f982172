// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <mapjoin/geometry/euler.hpp>
#include <mapjoin/io/files/mat_file.hpp>
#include <mapjoin/io/local_maps/named_local_map.hpp>
#include <set>

namespace mapjoin {
namespace {

tl::unexpected<Error> row_error(const LocalMapFile& file, Eigen::Index row, const std::string& message) {
  return bad_input(fmt::format("{}: row {} of the state: {}", file.path.string(), row + 1, message));
}

tl::unexpected<Error> file_error(const LocalMapFile& file, const std::string& message) {
  return bad_input(fmt::format("{}: {}", file.path.string(), message));
}

/// How many rows from `row` on carry its id.
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

/// In space, the Gaussian over the angles (a, b, c) = (yaw, pitch, roll) is turned to be over the step of the rotation: by J a
/// covariance, by J⁻ᵀ an information matrix. In the plane the heading is the rotation's step already.
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

/// Whether the end pose is known to be the start pose: its rows and columns of the covariance are zero, and so is its motion.
template <int Dim>
bool coincides(const LocalMapFile& file) {
  return !file.is_information && file.state.col(1).head<kPoseDof<Dim>>().isZero(0.0) &&
         file.gaussian.topRows<kPoseDof<Dim>>().isZero(0.0) && file.gaussian.leftCols<kPoseDof<Dim>>().isZero(0.0);
}

}  // namespace

Expected<int> dimension(const LocalMapFile& file) {
  const Eigen::Index rows = file.state.rows() > 0 ? rows_of_one_id(file.state, 0) : 0;
  // The end pose's id may be 0, and so may the first feature's.
  if (rows == kPoseDof<2> || rows == kPoseDof<2> + 2) return 2;
  if (rows == kPoseDof<3> || rows == kPoseDof<3> + 3) return 3;
  return file_error(file, fmt::format("the state begins with {} rows of one id; an end pose has 3 or 6", rows));
}

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

template Expected<NamedLocalMap<2>> named_local_map<2>(LocalMapFile&&, InformationCheck&);
template Expected<NamedLocalMap<3>> named_local_map<3>(LocalMapFile&&, InformationCheck&);

}  // namespace mapjoin
