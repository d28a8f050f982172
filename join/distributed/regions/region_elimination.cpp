// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/regions/region_elimination.hpp>
#include <mapjoin/join/free_to_move.hpp>
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
std::string RegionElimination<Dim>::free_to_move(const PoseIds& poses, const FeatureIds& features) {
  const auto singular = system_.factorise(0.0);
  if (!singular) return "";
  const Eigen::MatrixXd directions = equations().to_variables(solver_->null_space(kMostFreeDirections));
  return mapjoin::free_to_move(system_, {*singular, directions}, poses, features);
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::forward(const Eigen::VectorXd& b) const {
  return solver_->solve_lower(equations().to_columns(b));
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::backward(Eigen::VectorXd y) const {
  return equations().to_variables(solver_->solve_upper(std::move(y)));
}

template class RegionElimination<2>;
template class RegionElimination<3>;

}  // namespace mapjoin::distributed
