// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/normal_equations.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Sorts each list lists[begin[k] .. begin[k+1]) and drops what is repeated.
void sort_and_unite(std::vector<std::int64_t>& begin, std::vector<Index>& lists) {
  std::int64_t kept = 0;
  for (std::size_t k = 0; k + 1 < begin.size(); ++k) {
    const auto first = lists.begin() + begin[k];
    const auto last = lists.begin() + begin[k + 1];
    std::sort(first, last);
    const auto end = std::unique(first, last);
    begin[k] = kept;
    kept = std::move(first, end, lists.begin() + kept) - lists.begin();
  }
  begin.back() = kept;
  lists.resize(static_cast<std::size_t>(kept));
}

/// Calls f(a, b) for every pair of variables of every clique, each pair once.
template <typename F>
void for_each_pair(const Cliques& cliques, F&& f) {
  for (std::size_t c = 0; c < cliques.size(); ++c) {
    const auto slots = cliques[c];
    for (std::size_t j = 0; j < slots.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        if (slots[i] != kConstant && slots[j] != kConstant) f(slots[i], slots[j]);
      }
    }
  }
}

/// Compressed lists of the values that `for_each(f)` gives as f(list, value).
template <typename ForEach>
std::pair<std::vector<std::int64_t>, std::vector<Index>> compress(std::size_t count, ForEach&& for_each) {
  std::vector<std::int64_t> begin(count + 1, 0);
  for_each([&](Index list, Index) { ++begin[static_cast<std::size_t>(list) + 1]; });
  for (std::size_t k = 0; k < count; ++k) begin[k + 1] += begin[k];
  std::vector<Index> lists(static_cast<std::size_t>(begin.back()));
  std::vector<std::int64_t> next(begin.begin(), begin.end() - 1);
  for_each([&](Index list, Index value) { lists[static_cast<std::size_t>(next[static_cast<std::size_t>(list)]++)] = value; });
  sort_and_unite(begin, lists);
  return {std::move(begin), std::move(lists)};
}

}  // namespace

NormalEquations::NormalEquations(std::vector<int> dofs, Cliques cliques)
    : dofs_(std::move(dofs)), cliques_(std::move(cliques)) {
  offsets_.assign(dofs_.size() + 1, 0);
  for (std::size_t v = 0; v < dofs_.size(); ++v) offsets_[v + 1] = offsets_[v] + dofs_[v];
  gradient_.setZero(size());
  order_variables();
  lay_out();
  if (size() > 0) cholesky_.analyse(matrix_);
}

void NormalEquations::order_variables() {
  auto [begin, neighbours] = compress(dofs_.size(), [&](auto&& f) {
    for_each_pair(cliques_, [&](Index a, Index b) {
      f(a, b);
      f(b, a);
    });
  });
  order_ = elimination_order({std::move(begin), std::move(neighbours)});
  place_ = inverse_order(order_);
  place_offsets_.assign(order_.size() + 1, 0);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    place_offsets_[k + 1] = place_offsets_[k] + dofs_[static_cast<std::size_t>(order_[k])];
  }
}

NormalEquations::BlockColumns NormalEquations::block_columns() const {
  auto [begin, rows] = compress(dofs_.size(), [&](auto&& f) {
    for (std::size_t v = 0; v < dofs_.size(); ++v) f(place_[v], place_[v]);
    for_each_pair(cliques_, [&](Index a, Index b) {
      const auto [low, high] = std::minmax(place_[static_cast<std::size_t>(a)], place_[static_cast<std::size_t>(b)]);
      f(low, high);
    });
  });
  return {std::move(begin), std::move(rows)};
}

void NormalEquations::lay_out() {
  const BlockColumns columns = block_columns();
  const auto dof_at = [&](Index place) { return dofs_[static_cast<std::size_t>(order_[static_cast<std::size_t>(place)])]; };

  // Where each block begins within its scalar columns, and how long these are.
  std::vector<std::int64_t> row_offsets(columns.rows.size());
  strides_.assign(order_.size(), 0);
  diagonal_.assign(order_.size(), 0);
  std::vector<std::int64_t> first_value(order_.size() + 1, 0);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    for (auto r = columns.begin[k]; r < columns.begin[k + 1]; ++r) {
      row_offsets[static_cast<std::size_t>(r)] = strides_[k];
      strides_[k] += dof_at(columns.rows[static_cast<std::size_t>(r)]);
    }
    diagonal_[k] = first_value[k];
    first_value[k + 1] = first_value[k] + strides_[k] * dof_at(static_cast<Index>(k));
  }

  matrix_.column_begin.assign(1, 0);
  matrix_.rows.reserve(static_cast<std::size_t>(first_value.back()));
  for (std::size_t k = 0; k < order_.size(); ++k) {
    for (int c = 0; c < dof_at(static_cast<Index>(k)); ++c) {
      for (auto r = columns.begin[k]; r < columns.begin[k + 1]; ++r) {
        const auto row = static_cast<std::size_t>(columns.rows[static_cast<std::size_t>(r)]);
        for (auto i = place_offsets_[row]; i < place_offsets_[row + 1]; ++i) matrix_.rows.push_back(i);
      }
      matrix_.column_begin.push_back(static_cast<std::int64_t>(matrix_.rows.size()));
    }
  }
  matrix_.values.assign(matrix_.rows.size(), 0.0);

  const auto destination = [&](Index a, Index b) -> std::int64_t {
    if (a == kConstant || b == kConstant) return 0;
    const auto [low, high] = std::minmax(place_[static_cast<std::size_t>(a)], place_[static_cast<std::size_t>(b)]);
    const auto column = static_cast<std::size_t>(low);
    const auto first = columns.rows.begin() + columns.begin[column];
    const auto found = std::lower_bound(first, columns.rows.begin() + columns.begin[column + 1], high);
    return first_value[column] + row_offsets[static_cast<std::size_t>(found - columns.rows.begin())];
  };
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    destination_begin_.push_back(static_cast<std::int64_t>(destinations_.size()));
    const auto slots = cliques_[c];
    for (std::size_t j = 0; j < slots.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) destinations_.push_back(destination(slots[i], slots[j]));
    }
  }
}

void NormalEquations::set_zero() {
  std::fill(matrix_.values.begin(), matrix_.values.end(), 0.0);
  gradient_.setZero();
}

Eigen::VectorXd NormalEquations::diagonal() const {
  Eigen::VectorXd diagonal(size());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto v = static_cast<std::size_t>(order_[k]);
    for (int i = 0; i < dofs_[v]; ++i) {
      diagonal[offsets_[v] + i] = matrix_.values[static_cast<std::size_t>(diagonal_[k] + i * (strides_[k] + 1))];
    }
  }
  return diagonal;
}

Eigen::MatrixXd NormalEquations::permuted(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto variable = static_cast<std::size_t>(order_[k]);
    out.middleRows(place_offsets_[k], dofs_[variable]) = columns.middleRows(offsets_[variable], dofs_[variable]);
  }
  return out;
}

Eigen::VectorXd NormalEquations::product(const Eigen::VectorXd& v) const {
  Eigen::VectorXd Hv = Eigen::VectorXd::Zero(v.size());
  for (std::int64_t j = 0; j < matrix_.size(); ++j) {
    for (auto k = matrix_.column_begin[static_cast<std::size_t>(j)]; k < matrix_.column_begin[static_cast<std::size_t>(j) + 1];
         ++k) {
      const std::int64_t i = matrix_.rows[static_cast<std::size_t>(k)];
      if (i < j) continue;
      const double value = matrix_.values[static_cast<std::size_t>(k)];
      Hv[i] += value * v[j];
      if (i > j) Hv[j] += value * v[i];
    }
  }
  return Hv;
}

double NormalEquations::curvature(const Eigen::VectorXd& v) const {
  const Eigen::VectorXd p = permuted(v);
  return p.dot(product(p));
}

SparseLower NormalEquations::principal_submatrix(const std::vector<bool>& is_kept) const {
  std::vector<std::int64_t> kept_before(is_kept.size(), 0);
  for (std::size_t j = 1; j < is_kept.size(); ++j) kept_before[j] = kept_before[j - 1] + (is_kept[j - 1] ? 1 : 0);
  SparseLower part;
  part.column_begin = {0};
  for (std::size_t j = 0; j < is_kept.size(); ++j) {
    if (!is_kept[j]) continue;
    for (auto k = static_cast<std::size_t>(matrix_.column_begin[j]); k < static_cast<std::size_t>(matrix_.column_begin[j + 1]);
         ++k) {
      const auto i = static_cast<std::size_t>(matrix_.rows[k]);
      if (i < j || !is_kept[i]) continue;
      part.rows.push_back(kept_before[i]);
      part.values.push_back(matrix_.values[k]);
    }
    part.column_begin.push_back(static_cast<std::int64_t>(part.rows.size()));
  }
  return part;
}

std::optional<double> NormalEquations::least_curvature(const Eigen::VectorXd& v, const std::vector<bool>& is_given) const {
  Eigen::VectorXd w = permuted(v);
  std::vector<bool> is_free(static_cast<std::size_t>(size()));
  std::vector<Eigen::Index> free;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    if (is_given[static_cast<std::size_t>(order_[k])]) continue;
    for (auto row = place_offsets_[k]; row < place_offsets_[k + 1]; ++row) {
      is_free[static_cast<std::size_t>(row)] = true;
      free.push_back(row);
      w[row] = 0.0;
    }
  }
  if (free.empty()) return w.dot(product(w));
  const SparseLower H_free = principal_submatrix(is_free);
  SparseCholesky cholesky;
  cholesky.analyse(H_free);
  if (cholesky.factorise(H_free)) return std::nullopt;
  w(free) = -cholesky.solve(product(w)(free));
  return w.dot(product(w));
}

void NormalEquations::set_diagonal(const Eigen::VectorXd& diagonal) {
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto v = static_cast<std::size_t>(order_[k]);
    for (int i = 0; i < dofs_[v]; ++i) {
      matrix_.values[static_cast<std::size_t>(diagonal_[k] + i * (strides_[k] + 1))] = diagonal[offsets_[v] + i];
    }
  }
}

std::optional<Index> NormalEquations::factorise(double damping) {
  if (size() == 0) return std::nullopt;
  const Eigen::VectorXd undamped = damping > 0.0 ? diagonal() : Eigen::VectorXd();
  if (damping > 0.0) damp(damping);
  const auto column = cholesky_.factorise(matrix_);
  if (damping > 0.0) set_diagonal(undamped);
  if (!column) return std::nullopt;
  const auto place = std::upper_bound(place_offsets_.begin(), place_offsets_.end(), *column) - place_offsets_.begin() - 1;
  return order_[static_cast<std::size_t>(place)];
}

Eigen::MatrixXd NormalEquations::solve_columns(const Eigen::MatrixXd& B) const {
  if (size() == 0) return B;
  const Eigen::MatrixXd X = cholesky_.solve_columns(permuted(B));
  Eigen::MatrixXd out(X.rows(), X.cols());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto variable = static_cast<std::size_t>(order_[k]);
    out.middleRows(offsets_[variable], dofs_[variable]) = X.middleRows(place_offsets_[k], dofs_[variable]);
  }
  return out;
}

}  // namespace mapjoin
