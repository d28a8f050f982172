// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/solve/cross_covariances.hpp>
#include <mapjoin/solve/engines/frontal_matrix.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

/// The number of variables whose columns of the inverse are found at once: dense products pay, and their memory stays small
/// beside the factor's.
constexpr std::size_t kVariablesAtOnce = 16;

/// The first row of L below the block of a supernode, a column of its parent; nullopt for a root.
std::optional<std::int64_t> first_below(const Supernode& node) {
  const auto width = static_cast<std::size_t>(node.width());
  return node.rows.size() > width ? std::optional(node.rows[width]) : std::nullopt;
}

}  // namespace

Supernodes CrossCovariances::on_paths(std::span<const Variable> variables) const {
  std::map<std::int64_t, Supernode> nodes;  // by the ends of their columns
  for (const Variable v : variables) {
    std::optional<std::int64_t> column = equations_.factor_column(v);
    const auto is_new = [&] {
      const auto next = nodes.upper_bound(*column);
      return next == nodes.end() || *column < next->second.begin;
    };
    while (column && is_new()) {
      Supernode node = equations_.supernode_of(*column);
      column = first_below(node);
      nodes.emplace(node.end, std::move(node));
    }
  }
  Supernodes ascending;
  ascending.reserve(nodes.size());
  for (auto& [end, node] : nodes) ascending.push_back(std::move(node));
  return ascending;
}

CrossCovariances::RowsOnPaths CrossCovariances::zeros_on_paths(std::span<const Variable> variables, Eigen::Index rows) const {
  RowsOnPaths zeros{on_paths(variables), {0}, {}};
  for (const Supernode& node : zeros.nodes) zeros.first.push_back(zeros.first.back() + node.width());
  zeros.values.setZero(rows, zeros.first.back());
  return zeros;
}

Eigen::Index CrossCovariances::size_of(std::span<const Variable> variables) const {
  Eigen::Index size = 0;
  for (const Variable v : variables) size += equations_.dof(v);
  return size;
}

Eigen::Index CrossCovariances::column_in(const RowsOnPaths& rows, Variable v) const {
  const std::int64_t column = equations_.factor_column(v);
  const auto node = std::ranges::upper_bound(rows.nodes, column, {}, &Supernode::end);
  return rows.first[static_cast<std::size_t>(node - rows.nodes.begin())] + column - node->begin;
}

/// The columns of `values` for the rows of L below its k-th node.
std::vector<Eigen::Index> CrossCovariances::columns_below(const RowsOnPaths& rows, std::size_t k) const {
  const Supernode& node = rows.nodes[k];
  std::vector<Eigen::Index> columns;
  std::size_t above = k;
  for (const std::int64_t row : std::span(node.rows).subspan(static_cast<std::size_t>(node.width()))) {
    while (row >= rows.nodes[above].end) ++above;
    columns.push_back(rows.first[above] + row - rows.nodes[above].begin);
  }
  return columns;
}

CrossCovariances::RowsOnPaths CrossCovariances::substitute_forward(std::span<const Variable> variables,
                                                                   const Eigen::MatrixXd& of_these) const {
  const Eigen::Index size = of_these.cols();
  RowsOnPaths Y = zeros_on_paths(variables, size);
  for (Eigen::Index row = 0; const Variable v : variables) {
    const Eigen::Index dof = equations_.dof(v);
    Y.values.middleCols(column_in(Y, v), dof) += of_these.middleRows(row, dof).transpose();
    row += dof;
  }
  for (std::size_t k = 0; k < Y.nodes.size(); ++k) {
    const Supernode& node = Y.nodes[k];
    const Eigen::Index width = node.width();
    const auto height = static_cast<Eigen::Index>(node.rows.size());
    const DenseBlock own(Y.values.col(Y.first[k]).data(), size, width, Stride(size));
    divide_by_transpose({node.values, width, width, Stride(height)}, own);
    Eigen::MatrixXd sent(size, height - width);
    subtract_product(constant(own), {node.values + width, height - width, width, Stride(height)},
                     {sent.data(), size, height - width, Stride(size)}, Into::kNew);
    Y.values(Eigen::all, columns_below(Y, k)) += sent;
  }
  return Y;
}

CrossCovariances::RowsOnPaths CrossCovariances::substitute_back(const RowsOnPaths& Y_transposed,
                                                                std::span<const Variable> variables) const {
  RowsOnPaths X = zeros_on_paths(variables, Y_transposed.values.rows());
  for (std::size_t k = X.nodes.size(); k-- > 0;) {
    const Supernode& node = X.nodes[k];
    const Eigen::Index width = node.width();
    const auto height = static_cast<Eigen::Index>(node.rows.size());
    auto own = X.values.middleCols(X.first[k], width);
    const auto in_Y = std::ranges::lower_bound(Y_transposed.nodes, node.begin, {}, &Supernode::begin);
    if (in_Y != Y_transposed.nodes.end() && in_Y->begin == node.begin) {
      own = Y_transposed.values.middleCols(Y_transposed.first[static_cast<std::size_t>(in_Y - Y_transposed.nodes.begin())],
                                           width);
    }
    const Eigen::MatrixXd below = X.values(Eigen::all, columns_below(X, k));
    own.noalias() -= below * ConstDenseBlock(node.values + width, height - width, width, Stride(height));
    ConstDenseBlock(node.values, width, width, Stride(height)).triangularView<Lower>().solveInPlace<Eigen::OnTheRight>(own);
  }
  return X;
}

Eigen::MatrixXd CrossCovariances::between(std::span<const Variable> rows, std::span<const Variable> columns) const {
  const Eigen::Index size = size_of(rows);
  const RowsOnPaths X = substitute_back(substitute_forward(rows, Eigen::MatrixXd::Identity(size, size)), columns);
  return columns_of(columns, X);
}

Eigen::MatrixXd CrossCovariances::solved(std::span<const Variable> variables, const Eigen::MatrixXd& of_these) const {
  return columns_of(variables, substitute_back(substitute_forward(variables, of_these), variables)).transpose();
}

/// Columns of `rows`, those of some variables.
Eigen::MatrixXd CrossCovariances::columns_of(std::span<const Variable> variables, const RowsOnPaths& rows) const {
  Eigen::MatrixXd columns(rows.values.rows(), size_of(variables));
  for (Eigen::Index column = 0; const Variable v : variables) {
    const Eigen::Index dof = equations_.dof(v);
    columns.middleCols(column, dof) = rows.values.middleCols(column_in(rows, v), dof);
    column += dof;
  }
  return columns;
}

Eigen::MatrixXd CrossCovariances::joint(std::span<const Variable> variables) const {
  const Eigen::Index size = size_of(variables);
  Eigen::MatrixXd covariance(size, size);
  Eigen::Index row = 0;
  for (std::size_t first = 0; first < variables.size(); first += kVariablesAtOnce) {
    const auto rest = variables.subspan(first);
    const Eigen::MatrixXd rows = between(rest.first(std::min(kVariablesAtOnce, rest.size())), rest);
    covariance.block(row, row, rows.rows(), rows.cols()) = rows;
    row += rows.rows();
  }
  covariance.triangularView<Eigen::StrictlyLower>() = covariance.transpose();
  return covariance;
}

std::int64_t CrossCovariances::bytes(std::span<const Variable> variables) const {
  const std::int64_t size = size_of(variables);
  const std::int64_t at_once = size_of(variables.first(std::min(kVariablesAtOnce, variables.size())));
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::int64_t nodes = 0;
  for (const Supernode& node : on_paths(variables)) {
    rows += std::ssize(node.rows);
    columns += node.width();
    ++nodes;
  }
  // Memory of the supernodes of both substitutions, the second time also on their way into a list; of Yᵀ, (L⁻ᵀ Y)ᵀ and the work
  // at one supernode; of the rows of the variables at once; and of the covariance.
  const std::int64_t lists = 2 * 8 * (rows + nodes) + 4 * nodes * static_cast<std::int64_t>(sizeof(Supernode));
  return lists + 8 * (4 * at_once * columns + 2 * size * size);
}

}  // namespace mapjoin
