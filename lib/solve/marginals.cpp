// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/engines/frontal_matrix.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

/// A view of `room` as a dense matrix.
DenseBlock block_in(std::vector<double>& room, Eigen::Index rows, Eigen::Index columns) {
  return {room.data(), rows, columns, Stride(rows)};
}

/// Totals to store, and the most columns of a supernode, rows below one, and entries below one.
struct Size {
  std::int64_t rows = 0;
  std::int64_t values = 0;
  std::int64_t widest = 0;
  std::int64_t most_below = 0;
  std::int64_t most_entries_below = 0;

  explicit Size(const Supernodes& factor) {
    for (const Supernode& L : factor) {
      const auto height = static_cast<std::int64_t>(L.rows.size());
      const std::int64_t width = L.width();
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
    node_of_.insert(node_of_.end(), static_cast<std::size_t>(L.width()), static_cast<std::int32_t>(nodes_.size()));
    nodes_.push_back({L.begin, L.end, {rows_.data() + rows_.size() - L.rows.size(), L.rows.size()}, values});
    values += static_cast<std::int64_t>(L.rows.size()) * L.width();
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
  const Eigen::Index width = L.width();
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

Marginals::Marginals(const NormalEquations& equations, const InverseSubset::GoOn& go_on)
    : subset_(equations.supernodes(), go_on) {
  columns_.reserve(equations.variables().size());
  for (const Variable v : equations.variables()) columns_.push_back({equations.factor_column(v), equations.dof(v)});
}

std::int64_t Marginals::bytes(const NormalEquations& equations) {
  return InverseSubset::bytes(equations.supernodes()) +
         static_cast<std::int64_t>(equations.variables().size() * sizeof(Columns));
}

Eigen::MatrixXd Marginals::joint(std::span<const Variable> variables) const {
  std::vector<std::int64_t> columns;
  for (const Variable v : variables) {
    for (std::int64_t i = 0; i < columns_[v].count; ++i) columns.push_back(columns_[v].first + i);
  }
  return subset_.block(columns);
}

}  // namespace mapjoin
