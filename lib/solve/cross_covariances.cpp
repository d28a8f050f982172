// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/cross_covariances.hpp>
#include <mapjoin/solve/frontal_matrix.hpp>

namespace mapjoin {
namespace {

Eigen::Index width_of(const Supernode& node) {
  return node.end - node.begin;
}

}  // namespace

CrossCovariances::CrossCovariances(const NormalEquations& equations) : equations_(equations), factor_(equations.supernodes()) {
  for (std::size_t k = 0; k < factor_.size(); ++k) {
    node_of_.resize(static_cast<std::size_t>(factor_[k].end), k);
  }
}

std::vector<std::size_t> CrossCovariances::nodes_above(std::int64_t column) const {
  std::vector<std::size_t> nodes = {node_of(column)};
  while (true) {
    const Supernode& last = factor_[nodes.back()];
    const auto width = static_cast<std::size_t>(width_of(last));
    if (last.rows.size() == width) return nodes;
    nodes.push_back(node_of(last.rows[width]));
  }
}

CrossCovariances::Path CrossCovariances::path(Variable u) const {
  const std::int64_t column = equations_.factor_column(u);
  Path path{nodes_above(column), {}};
  std::vector<Eigen::Index> first;  // row of each node in Y, and their number
  first.push_back(0);
  for (const std::size_t node : path.nodes) first.push_back(first.back() + width_of(factor_[node]));
  path.Y.setZero(first.back(), equations_.dof(u));
  path.Y.middleRows(column - factor_[path.nodes.front()].begin, path.Y.cols()).setIdentity();
  for (std::size_t k = 0; k < path.nodes.size(); ++k) {
    const Supernode& node = factor_[path.nodes[k]];
    const Eigen::Index width = width_of(node);
    const auto height = static_cast<Eigen::Index>(node.rows.size());
    const ConstDenseBlock L(node.values, height, width, Eigen::OuterStride<>(height));
    auto own = path.Y.middleRows(first[k], width);
    L.topRows(width).triangularView<Eigen::Lower>().solveInPlace(own);
    const Eigen::MatrixXd sent = L.bottomRows(height - width) * own;
    std::size_t above = k + 1;
    for (Eigen::Index r = 0; r < sent.rows(); ++r) {
      const std::int64_t row = node.rows[static_cast<std::size_t>(width + r)];
      while (row >= factor_[path.nodes[above]].end) ++above;
      path.Y.row(first[above] + row - factor_[path.nodes[above]].begin) -= sent.row(r);
    }
  }
  return path;
}

Eigen::MatrixXd CrossCovariances::between(Variable u, Variable v) const {
  const Path of_u = path(u);
  const Path of_v = path(v);
  Eigen::Index common = 0;
  for (auto i = of_u.nodes.rbegin(), j = of_v.nodes.rbegin(); i != of_u.nodes.rend() && j != of_v.nodes.rend() && *i == *j;
       ++i, ++j) {
    common += width_of(factor_[*i]);
  }
  return of_u.Y.bottomRows(common).transpose() * of_v.Y.bottomRows(common);
}

}  // namespace mapjoin
