// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <mapjoin/distributed/region_elimination.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <int Dim>
Table<PoseIndex, Variable> pose_variables(const Region<Dim>& region) {
  Table<PoseIndex, Variable> variables(region.poses.size(), kConstant);
  Variable next = 0;
  region.for_each_free_pose([&](PoseIndex place, Eigen::Index) { variables[place] = next++; });
  return variables;
}

}  // namespace

template <int Dim>
RegionElimination<Dim>::RegionElimination(const Region<Dim>& region, const Values<Dim>& estimate, const Border& border,
                                          Table<Column, Variable>& order)
    : estimate_(estimate),
      graph_(factors_of(region)),
      pose_variables_(pose_variables(region)),
      first_feature_(region.poses.size() - region.anchored.size()),
      solver_(new SparseCholesky(Updates::kFreed, border.places.size())),
      equations_(pattern(), std::unique_ptr<SparseSolver>(solver_), ordering(border, order)) {
  if (order.empty()) order = equations_.order();
}

template <int Dim>
BlockPattern RegionElimination<Dim>::pattern() const {
  BlockPattern pattern;
  pattern.dofs.assign(first_feature_.position(), kPoseDof<Dim>);
  pattern.dofs.resize(first_feature_.position() + estimate_.features.size(), Dim);
  for (const auto& o : graph_.pose_factors) pattern.factors.push_back(std::array{variable(o.base), variable(o.target)});
  for (const auto& o : graph_.feature_factors) pattern.factors.push_back(std::array{variable(o.base), variable(o.target)});
  return pattern;
}

template <int Dim>
Ordering RegionElimination<Dim>::ordering(const Border& border, const Table<Column, Variable>& order) const {
  Ordering ordering{.given = order, .ranks = {}, .border = {}};
  for (const PoseOrFeature& placed : border.places) {
    ordering.border.push_back(std::visit([&](auto place) { return variable(place); }, placed));
  }
  return ordering;
}

template <int Dim>
double RegionElimination<Dim>::linearise(bool with_curvature) {
  const auto with_factor = [&](std::size_t factor, auto&& f) {
    if (factor < graph_.pose_factors.size()) {
      const auto& o = graph_.pose_factors[factor];
      return f(mapjoin::linearise(o, estimate_.pose(o.base), estimate_.poses[o.target]));
    }
    const auto& o = graph_.feature_factors[factor - graph_.pose_factors.size()];
    return f(mapjoin::linearise(o, estimate_.pose(o.base), estimate_.features[o.target]));
  };
  equations_.set_zero();
  const double chi2 = equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
    return with_factor(factor, [&](const auto& linear) { return accumulate(linear, sink); });
  });
  if (!with_curvature) return chi2;
  equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
    return with_factor(factor, [&](const auto& linear) {
      accumulate_curvature(linear, sink);
      return 0.0;
    });
  });
  return chi2;
}

template <int Dim>
std::optional<PoseOrFeature> RegionElimination<Dim>::factorise(double damping) {
  const auto singular = equations_.factorise(damping);
  if (!singular) return std::nullopt;
  if (*singular >= first_feature_) return FeatureIndex(*singular - first_feature_);
  return PoseIndex(std::ranges::find(pose_variables_, *singular) - pose_variables_.begin());
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::forward(const Eigen::VectorXd& b) const {
  Eigen::VectorXd y(b.size());
  for (const Variable v : equations_.variables()) {
    const int dof = equations_.dof(v);
    y.segment(equations_.factor_column(v), dof) = b.segment(equations_.offset(v), dof);
  }
  return solver_->solve_lower(std::move(y));
}

template <int Dim>
Eigen::VectorXd RegionElimination<Dim>::backward(Eigen::VectorXd y) const {
  y = solver_->solve_upper(std::move(y));
  Eigen::VectorXd x(y.size());
  for (const Variable v : equations_.variables()) {
    const int dof = equations_.dof(v);
    x.segment(equations_.offset(v), dof) = y.segment(equations_.factor_column(v), dof);
  }
  return x;
}

template class RegionElimination<2>;
template class RegionElimination<3>;

}  // namespace mapjoin::distributed
