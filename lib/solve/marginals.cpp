// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <mapjoin/solve/frontal_matrix.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace mapjoin {
namespace {

using Eigen::Lower;
using Stride = Eigen::OuterStride<>;

/// Right-hand sides solved at once: dense products pay, and their memory stays small beside the factor's.
constexpr Eigen::Index kColumnsAtOnce = 64;

Eigen::Index width_of(const Supernode& node) {
  return node.end - node.begin;
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
  std::vector<Eigen::Index> first;  // column of Yᵀ that each node begins with, and their number
  first.push_back(0);
  for (const std::size_t node : path.nodes) first.push_back(first.back() + width_of(factor_[node]));
  const Eigen::Index dof = equations_.dof(u);
  path.Y_transposed.setZero(dof, first.back());
  path.Y_transposed.middleCols(column - factor_[path.nodes.front()].begin, dof).setIdentity();
  for (std::size_t k = 0; k < path.nodes.size(); ++k) {
    const Supernode& node = factor_[path.nodes[k]];
    const Eigen::Index width = width_of(node);
    const auto height = static_cast<Eigen::Index>(node.rows.size());
    const DenseBlock own(path.Y_transposed.col(first[k]).data(), dof, width, Stride(dof));
    divide_by_transpose({node.values, width, width, Stride(height)}, own);
    if (height == width) break;  // the root
    Eigen::MatrixXd sent(dof, height - width);
    subtract_product(constant(own), {node.values + width, height - width, width, Stride(height)},
                     {sent.data(), dof, height - width, Stride(dof)}, Into::kNew);
    std::size_t above = k + 1;
    for (Eigen::Index r = 0; r < sent.cols(); ++r) {
      const std::int64_t row = node.rows[static_cast<std::size_t>(width + r)];
      while (row >= factor_[path.nodes[above]].end) ++above;
      path.Y_transposed.col(first[above] + row - factor_[path.nodes[above]].begin) += sent.col(r);
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
  return of_u.Y_transposed.rightCols(common) * of_v.Y_transposed.rightCols(common).transpose();
}

Eigen::MatrixXd covariance_of(const NormalEquations& equations, const Eigen::SparseMatrix<double>& J_transposed) {
  const Eigen::Index size = J_transposed.cols();
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index first = 0; first < size; first += kColumnsAtOnce) {
    const Eigen::Index count = std::min(kColumnsAtOnce, size - first);
    const Eigen::MatrixXd solution = equations.solve_columns(J_transposed.middleCols(first, count));
    covariance.middleCols(first, count) = J_transposed.transpose() * solution;
  }
  return 0.5 * (covariance + covariance.transpose());
}

std::int64_t covariance_bytes(const NormalEquations& equations, Eigen::Index rows) {
  // The result and its transpose; a batch of right-hand sides, permuted, solved, copied and permuted back.
  return 8 * (2 * rows * rows + 6 * kColumnsAtOnce * equations.size());
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
