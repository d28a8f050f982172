// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/regions/region_problem.hpp>
#include <mapjoin/join/free_to_move.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The factors of a region, which gives them up.
template <int Dim>
FactorGraph<Dim> taken_factors(Region<Dim>& region) {
  FactorGraph<Dim> graph = factors_of(region);
  release(region.factors);
  return graph;
}

}  // namespace

template <int Dim>
RegionProblem<Dim>::RegionProblem(const Communicator& comm, Regions<Dim>& regions, const MumpsOptions& options)
    : comm_(comm),
      region_(regions.own.front()),
      graph_(taken_factors(regions.own.front())),
      interface_(interface_of(comm, regions)),
      solver_(new RegionSolver(comm, interface_.outer, interface_.borders.front().places.size(), options)),
      system_(partial_map_of(region_, graph_, region_.start), {region_.anchored, {}}, std::unique_ptr<SparseSolver>(solver_),
              interface_.borders.front().places),
      shared_{interface_.size, entries_of(interface_.borders.front(), region_), interface_.borders.front().unknowns} {}

template <int Dim>
std::optional<Variable> RegionProblem<Dim>::factorise(double damping) {
  const auto singular = system_.factorise(damping);
  singular_here_ = solver_->is_singular_here() ? singular : std::nullopt;
  return singular;
}

template <int Dim>
std::string RegionProblem<Dim>::free_here(const LogPart<Dim>& whole) const {
  if (!singular_here_) return "";
  const Eigen::MatrixXd directions = system_.equations().to_variables(solver_->null_space_here(kMostFreeDirections));
  return free_to_move(system_, {*singular_here_, directions}, names_at(region_.poses, whole.poses),
                      names_at(region_.features, whole.features));
}

template <int Dim>
StepSize RegionProblem<Dim>::step_size(const Eigen::VectorXd& step) const {
  const StepSize own = system_.step_size(step);
  return {comm_.max(own.metres), comm_.max(own.radians)};
}

template class RegionProblem<2>;
template class RegionProblem<3>;

}  // namespace mapjoin::distributed
