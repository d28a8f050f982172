// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/join/free_to_move.hpp>
#include <mapjoin/solve/free_directions.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// The least and the largest positive diagonal entry of all information matrices.
template <int Dim>
std::pair<double, double> weights_of(const JoiningSystem<Dim>& system) {
  std::pair range(std::numeric_limits<double>::infinity(), 0.0);
  const auto take = [&](const auto& information) {
    for (const double weight : information.diagonal()) {
      if (weight > 0.0) range = {std::min(range.first, weight), std::max(range.second, weight)};
    }
  };
  for (const auto& factor : system.pose_factors()) take(factor.observation->information);
  for (const auto& factor : system.feature_factors()) take(factor.observation->information);
  for (const auto& placed : system.maps()) take(placed.map->information);
  return range;
}

/// Advice in words if the largest weights leave no digits to the least; "" otherwise.
template <int Dim>
std::string lost_weights_in_words(const JoiningSystem<Dim>& system) {
  constexpr double kFarApart = 1e12;
  const auto [least, largest] = weights_of(system);
  if (!(largest > kFarApart * least)) return "";
  return fmt::format("; weights from {:.2g} to {:.2g} are too far apart to be added: bring them closer together", least,
                     largest);
}

}  // namespace

template <int Dim>
std::string free_to_move(const JoiningSystem<Dim>& system, Variable singular, const Eigen::MatrixXd& null_space,
                         const PoseIds& pose_ids, const FeatureIds& feature_ids) {
  const NormalEquations& equations = system.equations();
  std::vector<PlacedVariable<Dim>> variables;
  for (const PoseIndex p : indices(pose_ids)) {
    const Variable v = system.variable(p);
    const Eigen::Index offset = v == kConstant ? -1 : equations.offset(v);
    variables.push_back({to_string(pose_ids[p]), system.estimate().poses[p], offset, true});
  }
  for (const FeatureIndex f : indices(feature_ids)) {
    const Pose<Dim> place{system.estimate().features[f], {}};
    variables.push_back({to_string(feature_ids[f]), place, equations.offset(system.variable(f)), false});
  }
  const std::string found = free_directions(variables, null_space);
  const std::string& name = std::ranges::find(variables, equations.offset(singular), &PlacedVariable<Dim>::offset)->name;
  return (found.empty() ? name + " cannot be determined" : found) + lost_weights_in_words(system);
}

template std::string free_to_move(const JoiningSystem<2>&, Variable, const Eigen::MatrixXd&, const PoseIds&, const FeatureIds&);
template std::string free_to_move(const JoiningSystem<3>&, Variable, const Eigen::MatrixXd&, const PoseIds&, const FeatureIds&);

}  // namespace mapjoin
