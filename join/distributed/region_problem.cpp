// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/region_problem.hpp>
#include <numeric>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The factors, given up.
template <int Dim>
FactorGraph<Dim> taken_factors(Region<Dim>& region) {
  FactorGraph<Dim> graph = factors_of(region);
  release(region.factors);
  return graph;
}

template <typename Index>
Table<Index, Index> places(std::size_t count) {
  Table<Index, Index> all(count);
  std::iota(all.begin(), all.end(), Index(0));
  return all;
}

/// A region as a partial map, by its places, and its gauge.
template <int Dim>
PartialMap<Dim> partial_map_of(const Region<Dim>& region, const FactorGraph<Dim>& graph) {
  PartialMap<Dim> partial{
      places<PoseIndex>(region.poses.size()), places<FeatureIndex>(region.features.size()), region.start, {}};
  for (const auto& o : graph.pose_factors) partial.factors.pose_factors.push_back(&o);
  for (const auto& o : graph.feature_factors) partial.factors.feature_factors.push_back(&o);
  return partial;
}

}  // namespace

template <int Dim>
RegionProblem<Dim>::RegionProblem(const Communicator& comm, Regions<Dim>& regions, const MumpsOptions& options)
    : comm_(comm),
      region_(regions.own.front()),
      graph_(taken_factors(regions.own.front())),
      interface_(interface_of(comm, regions)),
      solver_(new RegionSolver(comm, interface_.outer, interface_.borders.front().places.size(), options)),
      system_(partial_map_of(region_, graph_), {region_.anchored, {}}, std::unique_ptr<SparseSolver>(solver_),
              interface_.borders.front().places),
      shared_{interface_.size, {}, interface_.borders.front().unknowns} {
  for (const PoseOrFeature& placed : interface_.borders.front().places) {
    const Variable v = std::visit([&](auto place) { return system_.variable(place); }, placed);
    for (int i = 0; i < system_.equations().dof(v); ++i) shared_.entries.push_back(system_.equations().offset(v) + i);
  }
}

template <int Dim>
std::optional<Variable> RegionProblem<Dim>::factorise(double damping) {
  const auto singular = system_.factorise(damping);
  singular_here_.reset();
  if (singular && solver_->is_singular_here()) {
    singular_here_ = std::visit([&](auto place) { return name_of(region_, place); }, system_.place_of_variable(*singular));
  }
  return singular;
}

template <int Dim>
StepSize RegionProblem<Dim>::step_size(const Eigen::VectorXd& step) const {
  const StepSize own = system_.step_size(step);
  return {comm_.max(own.metres), comm_.max(own.radians)};
}

template class RegionProblem<2>;
template class RegionProblem<3>;

}  // namespace mapjoin::distributed
