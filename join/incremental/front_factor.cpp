// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <mapjoin/join/incremental/front_factor.hpp>
#include <set>

namespace mapjoin {

std::vector<FrontFactor::NodeIndex> FrontFactor::way_to_root(std::span<const Variable> of) const {
  std::vector<NodeIndex> way;
  std::set<NodeIndex> met;
  for (const Variable v : of) {
    std::vector<NodeIndex> own;  // up to where it meets the others'
    for (NodeIndex n = variables[v].node; n != kNone && met.insert(n).second; n = nodes[n].parent) own.push_back(n);
    way.insert(way.begin(), own.begin(), own.end());
  }
  return way;
}

/// YᵀY with L Y = E, the columns of the identity of the variables; rows of Y are zero but on the way from their fronts to the
/// root.
std::optional<Eigen::MatrixXd> FrontFactor::covariance(std::span<const Variable> of) const {
  Eigen::Index size = 0;
  for (const Variable v : of) {
    if (variables[v].node == kNone) return std::nullopt;  // nothing is known of it
    size += variables[v].dof;
  }
  std::map<Variable, Eigen::MatrixXd> rhs;
  const auto rows_of = [&](Variable v) -> Eigen::MatrixXd& {
    return rhs.try_emplace(v, Eigen::MatrixXd::Zero(variables[v].dof, size)).first->second;
  };
  Eigen::Index column = 0;
  for (const Variable v : of) {
    rows_of(v).middleCols(column, variables[v].dof).setIdentity();
    column += variables[v].dof;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  for (const NodeIndex n : way_to_root(of)) {
    const Front& front = *nodes[n].front;
    if (front.is_singular) return std::nullopt;
    Eigen::MatrixXd Y(front.L.cols(), size);
    Eigen::Index row = 0;
    for (const Variable frontal : front.frontals) {
      Y.middleRows(row, variables[frontal].dof) = rows_of(frontal);
      row += variables[frontal].dof;
    }
    front.L.topRows(row).triangularView<Eigen::Lower>().solveInPlace(Y);
    covariance += Y.transpose() * Y;
    for (const Variable above : front.update.variables) {
      rows_of(above) -= front.L.middleRows(row, variables[above].dof) * Y;
      row += variables[above].dof;
    }
  }
  return covariance;
}

}  // namespace mapjoin
