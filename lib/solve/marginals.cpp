// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <mapjoin/solve/frontal_matrix.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

/// Variables whose columns of the inverse are found at once: dense products pay, and their memory stays small beside the
/// factor's.
constexpr std::size_t kVariablesAtOnce = 16;

Eigen::Index width_of(const Supernode& node) {
  return node.end - node.begin;
}

/// The first row of L below its block, a column of its parent; none of a root.
std::optional<std::int64_t> first_below(const Supernode& node) {
  const auto width = static_cast<std::size_t>(width_of(node));
  return node.rows.size() > width ? std::optional(node.rows[width]) : std::nullopt;
}

/// A dense matrix in `room`, whatever is in there.
DenseBlock block_in(std::vector<double>& room, Eigen::Index rows, Eigen::Index columns) {
  return {room.data(), rows, columns, Stride(rows)};
}

/// How much there is to keep, and the most columns of a supernode, rows below one, and entries there.
struct Size {
  std::int64_t rows = 0;
  std::int64_t values = 0;
  std::int64_t widest = 0;
  std::int64_t most_below = 0;
  std::int64_t most_entries_below = 0;

  explicit Size(const Supernodes& factor) {
    for (const Supernode& L : factor) {
      const auto height = static_cast<std::int64_t>(L.rows.size());
      const std::int64_t width = width_of(L);
      rows += height;
      values += height * width;
      widest = std::max(widest, width);
      most_below = std::max(most_below, height - width);
      most_entries_below = std::max(most_entries_below, (height - width) * width);
    }
  }
};

}  // namespace

std::int64_t InverseSubset::bytes(const Supernodes& factor) {
  const Size size(factor);
  const std::int64_t columns = factor.empty() ? 0 : factor.back().end;
  const auto nodes = static_cast<std::int64_t>(factor.size());
  const auto workspace = 2 * size.widest * size.widest + 2 * size.most_entries_below + size.most_below * (size.most_below + 1);
  return 8 * (size.values + size.rows + workspace) + 4 * columns + nodes * static_cast<std::int64_t>(sizeof(Node));
}

InverseSubset::InverseSubset(const Supernodes& factor, const GoOn& go_on) {
  const Size size(factor);
  rows_.reserve(static_cast<std::size_t>(size.rows));
  values_.resize(static_cast<std::size_t>(size.values));
  nodes_.reserve(factor.size());
  node_of_.reserve(factor.empty() ? 0 : static_cast<std::size_t>(factor.back().end));
  double* values = values_.data();
  for (const Supernode& L : factor) {
    rows_.insert(rows_.end(), L.rows.begin(), L.rows.end());
    node_of_.insert(node_of_.end(), static_cast<std::size_t>(width_of(L)), static_cast<std::int32_t>(nodes_.size()));
    nodes_.push_back({L.begin, L.end, {rows_.data() + rows_.size() - L.rows.size(), L.rows.size()}, values});
    values += static_cast<std::int64_t>(L.rows.size()) * width_of(L);
  }
  Workspace workspace;
  workspace.U.resize(static_cast<std::size_t>(size.widest * size.widest));
  workspace.minus_U.resize(workspace.U.size());
  workspace.G_transposed.resize(static_cast<std::size_t>(size.most_entries_below));
  workspace.Z_JR.resize(workspace.G_transposed.size());
  workspace.Z_RR.resize(static_cast<std::size_t>(size.most_below * size.most_below));
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    if (go_on && !go_on(nodes_.size() - 1 - k)) return;
    invert(factor[k], nodes_[k], workspace);
  }
}

void InverseSubset::invert(const Supernode& L, const Node& node, Workspace& workspace) const {
  const auto height = static_cast<Eigen::Index>(L.rows.size());
  const Eigen::Index width = width_of(L);
  const Eigen::Index below = height - width;
  DenseBlock U = block_in(workspace.U, width, width);
  U.setIdentity();
  divide_by_transpose({L.values, width, width, Stride(height)}, U);
  DenseBlock minus_U = block_in(workspace.minus_U, width, width);
  minus_U = -U;
  const DenseBlock Z_JJ(node.values, width, width, Stride(height));
  subtract_product(constant(minus_U), constant(U), Z_JJ, Into::kNew);
  if (below == 0) return;

  const DenseBlock G_transposed = block_in(workspace.G_transposed, width, below);
  subtract_product(constant(minus_U), {L.values + width, below, width, Stride(height)}, G_transposed, Into::kNew);
  DenseBlock Z_RR = block_in(workspace.Z_RR, below, below);
  gather(std::span(L.rows).subspan(static_cast<std::size_t>(width)), workspace.positions, Z_RR.data());
  Z_RR.triangularView<Eigen::StrictlyUpper>() = Z_RR.transpose();
  const DenseBlock Z_JR = block_in(workspace.Z_JR, width, below);
  subtract_product(constant(G_transposed), constant(Z_RR), Z_JR, Into::kNew);
  subtract_product(constant(G_transposed), constant(Z_JR), Z_JJ, Into::kSum);
  DenseBlock(node.values + width, below, width, Stride(height)) = Z_JR.transpose();
}

void InverseSubset::gather(std::span<const std::int64_t> places, std::vector<std::int64_t>& positions, double* out) const {
  const std::size_t size = places.size();
  positions.resize(size);
  for (std::size_t first = 0; first < size;) {
    const Node& node = nodes_[static_cast<std::size_t>(node_of_[static_cast<std::size_t>(places[first])])];
    auto row = node.rows.begin();
    for (std::size_t k = first; k < size; ++k) {
      row = std::lower_bound(row, node.rows.end(), places[k]);
      if (row == node.rows.end() || *row != places[k]) throw std::out_of_range("two columns are not coupled in the factor");
      positions[k] = row - node.rows.begin();
    }
    for (; first < size && places[first] < node.end; ++first) {
      const double* column = node.values + (places[first] - node.begin) * static_cast<std::int64_t>(node.rows.size());
      for (std::size_t k = first; k < size; ++k) out[first * size + k] = column[positions[k]];
    }
  }
}

Eigen::MatrixXd InverseSubset::block(std::span<const std::int64_t> columns) const {
  const auto size = static_cast<Eigen::Index>(columns.size());
  std::vector<Eigen::Index> order(columns.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto place = [&](Eigen::Index k) { return columns[static_cast<std::size_t>(k)]; };
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return place(a) < place(b); });
  std::vector<std::int64_t> places;
  places.reserve(columns.size());
  for (const Eigen::Index k : order) places.push_back(place(k));
  std::vector<std::int64_t> positions;
  Eigen::MatrixXd sorted(size, size);
  gather(places, positions, sorted.data());
  Eigen::MatrixXd block(size, size);
  block(order, order) = Eigen::MatrixXd(sorted.selfadjointView<Lower>());
  return block;
}

Eigen::MatrixXd Marginals::joint(std::span<const Variable> variables) const {
  std::vector<std::int64_t> columns;
  for (const Variable v : variables) {
    for (int i = 0; i < equations_->dof(v); ++i) columns.push_back(equations_->factor_column(v) + i);
  }
  return subset_.block(columns);
}

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
  for (const Supernode& node : zeros.nodes) zeros.first.push_back(zeros.first.back() + width_of(node));
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
  for (const std::int64_t row : std::span(node.rows).subspan(static_cast<std::size_t>(width_of(node)))) {
    while (row >= rows.nodes[above].end) ++above;
    columns.push_back(rows.first[above] + row - rows.nodes[above].begin);
  }
  return columns;
}

CrossCovariances::RowsOnPaths CrossCovariances::substitute_forward(std::span<const Variable> variables) const {
  const Eigen::Index size = size_of(variables);
  RowsOnPaths Y = zeros_on_paths(variables, size);
  for (Eigen::Index row = 0; const Variable v : variables) {
    const Eigen::Index dof = equations_.dof(v);
    Y.values.block(row, column_in(Y, v), dof, dof).setIdentity();
    row += dof;
  }
  for (std::size_t k = 0; k < Y.nodes.size(); ++k) {
    const Supernode& node = Y.nodes[k];
    const Eigen::Index width = width_of(node);
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
    const Eigen::Index width = width_of(node);
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
  const RowsOnPaths X = substitute_back(substitute_forward(rows), columns);
  Eigen::MatrixXd blocks(X.values.rows(), size_of(columns));
  for (Eigen::Index column = 0; const Variable v : columns) {
    const Eigen::Index dof = equations_.dof(v);
    blocks.middleCols(column, dof) = X.values.middleCols(column_in(X, v), dof);
    column += dof;
  }
  return blocks;
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
    columns += width_of(node);
    ++nodes;
  }
  // The supernodes of both substitutions, the second time also on their way into a list; Yᵀ, (L⁻ᵀ Y)ᵀ and what is done at one
  // supernode; of the variables at once what is asked for; and the covariance.
  const std::int64_t lists = 2 * 8 * (rows + nodes) + 4 * nodes * static_cast<std::int64_t>(sizeof(Supernode));
  return lists + 8 * (4 * at_once * columns + 2 * size * size);
}

std::int64_t machine_memory() {
  return std::int64_t{::sysconf(_SC_PHYS_PAGES)} * ::sysconf(_SC_PAGESIZE);
}

Expected<void> check_memory(const std::string& what, std::int64_t bytes, std::int64_t limit) {
  const std::int64_t most = limit > 0 ? limit : machine_memory();
  if (bytes <= most) return {};
  return tl::unexpected(Error{
      ErrorKind::kTooLarge,
      fmt::format("{} would take {:.1f} MB of memory, more than the {:.1f} MB {}", what, 1e-6 * static_cast<double>(bytes),
                  1e-6 * static_cast<double>(most), limit > 0 ? "allowed" : "of this machine")});
}

}  // namespace mapjoin
