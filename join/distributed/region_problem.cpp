// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/region_problem.hpp>
#include <utility>

namespace mapjoin::distributed {

Eigen::VectorXd RegionMetric::assembled(Eigen::VectorXd v) const {
  std::vector<double> shared(interface_.size, 0.0);
  for (std::size_t k = 0; k < entries_.size(); ++k) shared[static_cast<std::size_t>(interface_.unknowns[k])] = v[entries_[k]];
  comm_.sum(shared);
  for (std::size_t k = 0; k < entries_.size(); ++k) v[entries_[k]] = shared[static_cast<std::size_t>(interface_.unknowns[k])];
  return v;
}

template <int Dim>
RegionProblem<Dim>::RegionProblem(const Communicator& comm, const Region<Dim>& region, const MumpsOptions& options)
    : comm_(comm),
      interface_(interface_of(comm, region)),
      solver_(new RegionSolver(comm, interface_, options)),
      system_(region.partial, region.gauge, std::unique_ptr<SparseSolver>(solver_), interface_.border) {
  for (const PoseOrFeature& placed : interface_.border) {
    const Variable v = std::visit([&](auto place) { return system_.variable(place); }, placed);
    for (int i = 0; i < system_.equations().dof(v); ++i) entries_.push_back(system_.equations().offset(v) + i);
  }
}

template <int Dim>
StepSize RegionProblem<Dim>::step_size(const Eigen::VectorXd& step) const {
  const StepSize own = system_.step_size(step);
  return {comm_.max(own.metres), comm_.max(own.radians)};
}

template class RegionProblem<2>;
template class RegionProblem<3>;

}  // namespace mapjoin::distributed
