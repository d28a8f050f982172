// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/fit/dense_factor.hpp>
#include <mapjoin/join/free_to_move.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <mapjoin/solve/free_directions.hpp>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

/// A diagonal entry of an information matrix, ordered by its value with lengths in units of the extent of the map.
struct Weight {
  double of_extent = 0.0;
  double value = 0.0;
  auto operator<=>(const Weight&) const = default;
};

/// The least and the largest positive diagonal entry of all information matrices.
template <int Dim>
std::pair<Weight, Weight> weights_of(const JoiningSystem<Dim>& system, double extent) {
  std::pair range(Weight{std::numeric_limits<double>::infinity()}, Weight{});
  const auto take = [&](const auto& information, Eigen::Index pose_rows) {
    for (Eigen::Index row = 0; row < information.rows(); ++row) {
      const bool is_of_rotation = row < pose_rows && row % kPoseDof<Dim> >= Dim;
      const double value = information(row, row);
      const Weight weight{is_of_rotation ? value : value * extent * extent, value};
      if (value > 0.0) range = {std::min(range.first, weight), std::max(range.second, weight)};
    }
  };
  for (const auto& factor : system.pose_factors()) take(factor.observation->information, kPoseDof<Dim>);
  for (const auto& factor : system.feature_factors()) take(factor.observation->information, 0);
  for (const auto& [map, base, poses, features] : system.maps()) take(map->information, map->row(poses.size()));
  return range;
}

/// Advice in words if the largest weights leave no digits to the least; "" otherwise.
template <int Dim>
std::string lost_weights_in_words(const JoiningSystem<Dim>& system, double extent) {
  constexpr double kFarApart = 1e12;
  const auto [least, largest] = weights_of(system, extent);
  if (!(largest.of_extent > kFarApart * least.of_extent)) return "";
  return fmt::format(
      "; weights from {:.2g} to {:.2g} are too far apart to be added, as those of positions count times the square of the "
      "map's {:.2g} m beside those of rotations: bring them closer together",
      least.value, largest.value, extent);
}

/// The cost vᵀJᵀWJv of a direction v, summed factor by factor, how much of it may be rounding, and its gradient JᵀWJv.
struct Cost {
  double value = 0.0;
  double rounding = 0.0;
  Eigen::VectorXd gradient;
};

template <int Dim>
Cost cost_of(const Eigen::VectorXd& v, const JoiningSystem<Dim>& system) {
  constexpr double kRounding = 32.0 * std::numeric_limits<double>::epsilon();
  const NormalEquations& equations = system.equations();
  const Eigen::VectorXd size = v.cwiseAbs();
  Cost cost{0.0, 0.0, Eigen::VectorXd::Zero(v.size())};
  for (std::size_t factor = 0; factor < equations.pattern().factors.size(); ++factor) {
    const DenseFactor linear = dense_factor(system, factor);
    const Eigen::VectorXd Jv = times<Dim>(linear.J, v, factor, equations);
    const Eigen::VectorXd error = kRounding * times<Dim>(linear.J.cwiseAbs(), size, factor, equations);
    const Eigen::VectorXd WJv = linear.W * Jv;
    cost.value += Jv.dot(WJv);
    cost.rounding += error.dot(linear.W.cwiseAbs() * error);
    for_each_variable<Dim>(equations, factor, [&](Variable variable, Eigen::Index column) {
      const int dof = equations.dof(variable);
      cost.gradient.segment(equations.offset(variable), dof) += linear.J.middleCols(column, dof).transpose() * WJv;
    });
  }
  return cost;
}

/// The direction v of length 1 that costs least, vᵀHv / vᵀDv with the diagonal D of H, by the last factorisation (inverse
/// iteration).
Eigen::VectorXd softest_direction(const NormalEquations& equations) {
  constexpr int kSteps = 2;
  const Eigen::VectorXd D = equations.diagonal();
  RandomStream random(1, 0);
  Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(D.size(), [&] { return random.normal(); }).cwiseQuotient(D.cwiseSqrt());
  for (int k = 0; k < kSteps; ++k) v = equations.solve(D.cwiseProduct(v.stableNormalized()));
  return v.stableNormalized();
}

}  // namespace

template <int Dim>
bool is_surely_determined(const JoiningSystem<Dim>& system, const std::vector<MapFit>& fits) {
  constexpr Vertex kWorldVertex = 0;
  const auto vertex = [&](PoseIndex place) {
    return place == kWorld || system.is_anchored(place) ? kWorldVertex : static_cast<Vertex>(1 + place.value);
  };
  const auto is_full = [](const auto& W) { return information_rank(W) == W.rows(); };
  std::vector<Edge> ties;
  Table<FeatureIndex, bool> is_tied(system.estimate().features.size(), false);
  for (const auto& [o, base, target] : system.pose_factors()) {
    if (is_full(o->information)) ties.emplace_back(vertex(base), vertex(target));
  }
  for (const auto& [o, base, target] : system.feature_factors()) is_tied[target] = is_tied[target] || is_full(o->information);
  for (std::size_t m = 0; m < fits.size(); ++m) {
    const auto& [map, base, poses, features] = system.maps()[m];
    if (fits[m].rows < map->information.rows()) continue;
    for (const PoseIndex pose : poses) ties.emplace_back(vertex(base), vertex(pose));
    for (const FeatureIndex feature : features) is_tied[feature] = true;
  }
  const auto poses = indices(system.estimate().poses);
  const auto component = components_of(make_graph(1 + system.estimate().poses.size(), ties));
  return std::ranges::all_of(poses, [&](PoseIndex p) { return component[vertex(p)] == component[kWorldVertex]; }) &&
         std::ranges::find(is_tied, false) == is_tied.end();
}

template <int Dim>
Freedom freedom_at(Variable singular, const JoiningSystem<Dim>& system) {
  return {singular, system.equations().null_space(kMostFreeDirections)};
}

template <int Dim>
Freedom hidden_freedom(JoiningSystem<Dim>& system) {
  constexpr double kStiff = 1e-8;    // the share of vᵀDv beyond the rounding of H, a few ε a variable
  constexpr int kCorrections = 4;    // each takes out of v the rest of what is not free
  constexpr double kNothing = 1e-6;  // the share of v beyond which a correction has left nothing
  const NormalEquations& equations = system.equations();
  Eigen::VectorXd v = softest_direction(equations);
  if (equations.curvature(v) > kStiff * v.dot(equations.diagonal().cwiseProduct(v))) return {};
  system.linearise();
  if (const auto singular = system.factorise(0.0)) return freedom_at(*singular, system);
  v = softest_direction(equations);
  for (int k = 0; k < kCorrections && v.norm() > kNothing; ++k) {
    v.stableNormalize();
    const Cost cost = cost_of(v, system);
    if (cost.value <= cost.rounding) return {{}, v};
    v -= equations.solve(cost.gradient);
  }
  return {};
}

template <int Dim>
std::string free_to_move(const JoiningSystem<Dim>& system, const Freedom& freedom, const PoseIds& pose_ids,
                         const FeatureIds& feature_ids) {
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
  std::string found = free_directions(variables, freedom.directions);
  if (found.empty()) {  // the engine knows no direction
    const Eigen::Index offset = equations.offset(freedom.singular.value());
    found = std::ranges::find(variables, offset, &PlacedVariable<Dim>::offset)->name + " cannot be determined";
  }
  return found + lost_weights_in_words(system, extent_of(variables));
}

#define MAPJOIN_INSTANTIATE(Dim)                                                             \
  template bool is_surely_determined(const JoiningSystem<Dim>&, const std::vector<MapFit>&); \
  template Freedom freedom_at(Variable, const JoiningSystem<Dim>&);                          \
  template Freedom hidden_freedom(JoiningSystem<Dim>&);                                      \
  template std::string free_to_move(const JoiningSystem<Dim>&, const Freedom&, const PoseIds&, const FeatureIds&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
