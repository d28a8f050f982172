// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <tuple>
#include <utility>

namespace mapjoin {
namespace {

/// Lists, or cliques, that are worth a piece of work.
constexpr std::size_t kListsPerPiece = 100;

/// Sorts each list lists[begin[k] .. begin[k+1]) and drops what is repeated.
void sort_and_unite(std::vector<std::int64_t>& begin, std::vector<Index>& lists) {
  std::vector<std::int64_t> end(begin.size() - 1);
  parallel_chunks(end.size(), kListsPerPiece, [&](std::size_t k, std::size_t last) {
    for (; k < last; ++k) {
      const std::span list(lists.begin() + begin[k], lists.begin() + begin[k + 1]);
      std::ranges::sort(list);
      end[k] = begin[k] + (std::ranges::unique(list).begin() - list.begin());
    }
  });
  std::int64_t kept = 0;
  for (std::size_t k = 0; k < end.size(); ++k) {
    const auto united = std::move(lists.begin() + begin[k], lists.begin() + end[k], lists.begin() + kept);
    begin[k] = std::exchange(kept, united - lists.begin());
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
  parallel_invoke(
      [&] {
        find_destinations();
        share_out_cliques();
        colour_large_cliques();
      },
      [&] {
        if (size() > 0) cholesky_.analyse(matrix_);
      });
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
  matrix_.offsets.assign(order_.size() + 1, 0);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    matrix_.offsets[k + 1] = matrix_.offsets[k] + dofs_[static_cast<std::size_t>(order_[k])];
  }
}

void NormalEquations::lay_out() {
  std::tie(matrix_.begin, matrix_.rows) = compress(dofs_.size(), [&](auto&& f) {
    for (Index k = 0; k < variable_count(); ++k) f(k, k);
    for_each_pair(cliques_, [&](Index a, Index b) {
      const auto [low, high] = std::minmax({place(a), place(b)});
      f(low, high);
    });
  });
  matrix_.lay_out();
}

void NormalEquations::find_destinations() {
  std::vector<Eigen::Index> row_in_panel;
  row_in_panel.reserve(matrix_.rows.size());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    Eigen::Index height = 0;
    for (const Index row : matrix_.rows_of(k)) {
      row_in_panel.push_back(height);
      height += matrix_.dof(static_cast<std::size_t>(row));
    }
  }
  const auto destination = [&](Index a, Index b) -> std::int64_t {
    if (a == kConstant || b == kConstant) return 0;
    const auto [low, high] = std::minmax({place(a), place(b)});
    const auto column = static_cast<std::size_t>(low);
    const auto rows = matrix_.rows_of(column);
    const auto found = std::lower_bound(rows.begin(), rows.end(), high) - rows.begin();
    return matrix_.first_value[column] + row_in_panel[static_cast<std::size_t>(matrix_.begin[column] + found)];
  };
  destination_begin_.assign(1, 0);
  for (std::size_t c = 0; c < cliques_.size(); ++c) {
    const auto slots = static_cast<std::int64_t>(cliques_[c].size());
    destination_begin_.push_back(destination_begin_.back() + slots * (slots - 1) / 2);
  }
  destinations_.resize(static_cast<std::size_t>(destination_begin_.back()));
  parallel_chunks(cliques_.size(), kListsPerPiece, [&](std::size_t c, std::size_t end) {
    for (; c < end; ++c) {
      const auto slots = cliques_[c];
      std::int64_t* next = destinations_.data() + destination_begin_[c];
      for (std::size_t j = 0; j < slots.size(); ++j) {
        for (std::size_t i = 0; i < j; ++i) *next++ = destination(slots[i], slots[j]);
      }
    }
  });
}

void NormalEquations::set_zero() {
  std::fill(matrix_.values.begin(), matrix_.values.end(), 0.0);
  gradient_.setZero();
}

Eigen::VectorXd NormalEquations::diagonal() const {
  Eigen::VectorXd diagonal(size());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto v = static_cast<std::size_t>(order_[k]);
    for (int i = 0; i < dofs_[v]; ++i) diagonal[offsets_[v] + i] = matrix_.diagonal(k, i);
  }
  return diagonal;
}

Eigen::MatrixXd NormalEquations::permuted(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto variable = static_cast<std::size_t>(order_[k]);
    out.middleRows(matrix_.offsets[k], dofs_[variable]) = columns.middleRows(offsets_[variable], dofs_[variable]);
  }
  return out;
}

Eigen::VectorXd NormalEquations::product(const Eigen::VectorXd& v) const {
  Eigen::VectorXd Hv = Eigen::VectorXd::Zero(v.size());
  for (std::size_t k = 0; k < matrix_.blocks(); ++k) {
    const Eigen::Index dof = matrix_.dof(k);
    const Eigen::Map<const Eigen::MatrixXd> panel(matrix_.values.data() + matrix_.first_value[k], matrix_.heights[k], dof);
    const auto v_k = v.segment(matrix_.offsets[k], dof);
    Hv.segment(matrix_.offsets[k], dof) += panel.topRows(dof).selfadjointView<Eigen::Lower>() * v_k;
    Eigen::Index row = dof;
    for (const Index below : matrix_.rows_of(k).subspan(1)) {
      const auto i = static_cast<std::size_t>(below);
      const auto block = panel.middleRows(row, matrix_.dof(i));
      Hv.segment(matrix_.offsets[i], matrix_.dof(i)) += block.lazyProduct(v_k);
      Hv.segment(matrix_.offsets[k], dof) += block.transpose().lazyProduct(v.segment(matrix_.offsets[i], matrix_.dof(i)));
      row += matrix_.dof(i);
    }
  }
  return Hv;
}

double NormalEquations::curvature(const Eigen::VectorXd& v) const {
  const Eigen::VectorXd p = permuted(v);
  return p.dot(product(p));
}

BlockLower NormalEquations::principal_submatrix(const std::vector<bool>& is_kept) const {
  std::vector<Index> kept(is_kept.size());  // the place among those that are kept
  BlockLower part;
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    kept[k] = static_cast<Index>(part.blocks());
    if (is_kept[k]) part.offsets.push_back(part.offsets.back() + matrix_.dof(k));
  }
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    if (!is_kept[k]) continue;
    std::vector<Index> rows;
    for (const Index row : matrix_.rows_of(k)) {
      if (is_kept[static_cast<std::size_t>(row)]) rows.push_back(kept[static_cast<std::size_t>(row)]);
    }
    part.append_column(rows);
  }
  part.lay_out();
  double* to = part.values.data();
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    if (!is_kept[k]) continue;
    const double* from = matrix_.values.data() + matrix_.first_value[k];
    for (Eigen::Index j = 0; j < matrix_.dof(k); ++j) {
      for (const Index row : matrix_.rows_of(k)) {
        const Eigen::Index dof = matrix_.dof(static_cast<std::size_t>(row));
        if (is_kept[static_cast<std::size_t>(row)]) to = std::copy_n(from, dof, to);
        from += dof;
      }
    }
  }
  return part;
}

std::optional<double> NormalEquations::least_curvature(const Eigen::VectorXd& v, const std::vector<bool>& is_given) const {
  Eigen::VectorXd w = permuted(v);
  std::vector<bool> is_free(order_.size());
  std::vector<Eigen::Index> free;
  for (std::size_t k = 0; k < order_.size(); ++k) {
    is_free[k] = !is_given[static_cast<std::size_t>(order_[k])];
    if (!is_free[k]) continue;
    for (auto row = matrix_.offsets[k]; row < matrix_.offsets[k + 1]; ++row) {
      free.push_back(row);
      w[row] = 0.0;
    }
  }
  if (free.empty()) return w.dot(product(w));
  const BlockLower H_free = principal_submatrix(is_free);
  SparseCholesky cholesky;
  cholesky.analyse(H_free);
  if (cholesky.factorise(H_free)) return std::nullopt;
  w(free) = -cholesky.solve(product(w)(free));
  return w.dot(product(w));
}

void NormalEquations::set_diagonal(const Eigen::VectorXd& diagonal) {
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto v = static_cast<std::size_t>(order_[k]);
    for (int i = 0; i < dofs_[v]; ++i) matrix_.diagonal(k, i) = diagonal[offsets_[v] + i];
  }
}

std::optional<Index> NormalEquations::factorise(double damping) {
  if (size() == 0) return std::nullopt;
  const Eigen::VectorXd undamped = damping > 0.0 ? diagonal() : Eigen::VectorXd();
  if (damping > 0.0) damp(damping);
  const auto column = cholesky_.factorise(matrix_);
  if (damping > 0.0) set_diagonal(undamped);
  if (!column) return std::nullopt;
  const auto place = std::upper_bound(matrix_.offsets.begin(), matrix_.offsets.end(), *column) - matrix_.offsets.begin() - 1;
  return order_[static_cast<std::size_t>(place)];
}

Eigen::MatrixXd NormalEquations::solve_columns(const Eigen::MatrixXd& B) const {
  if (size() == 0) return B;
  const Eigen::MatrixXd X = cholesky_.solve_columns(permuted(B));
  Eigen::MatrixXd out(X.rows(), X.cols());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto variable = static_cast<std::size_t>(order_[k]);
    out.middleRows(offsets_[variable], dofs_[variable]) = X.middleRows(matrix_.offsets[k], dofs_[variable]);
  }
  return out;
}

}  // namespace mapjoin
