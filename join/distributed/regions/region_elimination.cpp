// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/regions/region_elimination.hpp>
#include <utility>

namespace mapjoin::distributed {

template <int Dim>
RegionElimination<Dim>::RegionElimination(const Region<Dim>& region, const Values<Dim>& estimate, const Border& border,
                                          std::vector<PoseOrFeature>& order)
    : graph_(factors_of(region)),
      solver_(new SparseCholesky(border.places.size())),
      system_(partial_map_of(region, graph_, estimate), {region.anchored, {}}, std::unique_ptr<SparseSolver>(solver_),
              border.places, order) {
  if (!order.empty()) return;
  for (const Variable v : equations().order()) order.push_back(system_.place_of_variable(v));
}

template <int Dim>
double RegionElimination<Dim>::linearise(bool with_curvature) {
  const double chi2 = system_.linearise();
  if (with_curvature) system_.add_curvature();
  return chi2;
}

template <int Dim>
std::optional<PoseOrFeature> RegionElimination<Dim>::factorise(double damping) {
  const auto singular = system_.factorise(damping);
  return singular ? std::optional(system_.place_of_variable(*singular)) : std::nullopt;
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::forward(const Eigen::VectorXd& b) const {
  Eigen::VectorXd y(b.size());
  for (const Variable v : equations().variables()) {
    const int dof = equations().dof(v);
    y.segment(equations().factor_column(v), dof) = b.segment(equations().offset(v), dof);
  }
  return solver_->solve_lower(std::move(y));
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::backward(Eigen::VectorXd y) const {
  y = solver_->solve_upper(std::move(y));
  Eigen::VectorXd x(y.size());
  for (const Variable v : equations().variables()) {
    const int dof = equations().dof(v);
    x.segment(equations().offset(v), dof) = y.segment(equations().factor_column(v), dof);
  }
  return x;
}

template class RegionElimination<2>;
template class RegionElimination<3>;

}  // namespace mapjoin::distributed
