// SPDX-License-Identifier: BSD-3-Clause
#include <apps/report/deviations.hpp>
#include <mapjoin/measure/median.hpp>
#include <utility>
#include <vector>

namespace mapjoin::apps {
namespace {

template <int Dim, typename Covariances, typename RelationsOfOne>
Deviations::Median medians(const Covariances& covariances, const RelationsOfOne& relations) {
  std::vector<double> in_map;
  std::vector<double> relative;
  for (std::size_t k = 0; k < covariances.size(); ++k) {
    if (covariances[k].isZero(0.0)) continue;  // held
    in_map.push_back(position_deviation<Dim>(covariances[k]));
    relative.push_back(position_deviation<Dim>(relations[k].covariance));
  }
  if (in_map.empty()) return {0.0, 0.0};
  return {median(std::move(in_map)), median(std::move(relative))};
}

}  // namespace

template <int Dim>
Deviations deviations_of(const MarginalCovariances<Dim>& marginals) {
  const Relations<Dim>& relations = marginals.relations;
  return {medians<Dim>(marginals.poses, relations.poses), medians<Dim>(marginals.features, relations.features)};
}

template Deviations deviations_of(const MarginalCovariances<2>&);
template Deviations deviations_of(const MarginalCovariances<3>&);

}  // namespace mapjoin::apps
