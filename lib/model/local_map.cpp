// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/local_map.hpp>

namespace mapjoin {

template <int Dim>
std::optional<std::string> fault(const LocalMap<Dim>& map) {
  if (map.pose_estimates.size() != map.poses.size() || map.feature_estimates.size() != map.features.size()) {
    return "has estimates that are not as many as its poses and features";
  }
  const auto is_sound = [](const auto& value) { return is_valid(value); };
  if (!std::all_of(map.pose_estimates.begin(), map.pose_estimates.end(), is_sound) ||
      !std::all_of(map.feature_estimates.begin(), map.feature_estimates.end(), is_sound)) {
    return "has an estimate that is not finite, or no rotation";
  }
  if (!std::isfinite(map.chi2)) return "has a chi2 that is not finite";
  const auto rows = map.row(map.poses.size() + map.features.size());
  if (map.information.rows() != rows || map.information.cols() != rows) {
    return fmt::format("has an information matrix of {} rows and {} columns for {} coordinates of its poses and features",
                       map.information.rows(), map.information.cols(), rows);
  }
  Eigen::MatrixXd W = map.information;
  const auto fault = InformationCheck().fault<Eigen::Dynamic>(W);
  return fault ? std::optional("has an information matrix that " + *fault) : std::nullopt;
}

template std::optional<std::string> fault(const LocalMap<2>&);
template std::optional<std::string> fault(const LocalMap<3>&);

}  // namespace mapjoin
