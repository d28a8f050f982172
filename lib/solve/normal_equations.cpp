// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <numeric>
#include <tuple>
#include <utility>

namespace mapjoin {
namespace {

/// Lists, or cliques, that are worth a piece of work.
constexpr std::size_t kListsPerPiece = 100;

/// Compressed lists, each ascending and without repetitions, of what gather(list, values) appends; on all threads.
template <typename Gather>
std::pair<std::vector<std::int64_t>, std::vector<Index>> sorted_lists(std::size_t count, Gather&& gather) {
  std::vector<std::int64_t> begin(count + 1, 0);
  std::vector<std::vector<Index>> values((count + kListsPerPiece - 1) / kListsPerPiece);  // list after list
  parallel_chunks(count, kListsPerPiece, [&](std::size_t first, std::size_t last) {
    std::vector<Index>& of_piece = values[first / kListsPerPiece];
    for (std::size_t k = first; k < last; ++k) {
      const auto size = static_cast<std::ptrdiff_t>(of_piece.size());
      gather(k, of_piece);
      std::sort(of_piece.begin() + size, of_piece.end());
      of_piece.erase(std::unique(of_piece.begin() + size, of_piece.end()), of_piece.end());
      begin[k + 1] = static_cast<std::int64_t>(of_piece.size()) - size;
    }
  });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Index> lists;
  lists.reserve(static_cast<std::size_t>(begin.back()));
  for (const auto& of_piece : values) lists.insert(lists.end(), of_piece.begin(), of_piece.end());
  return {std::move(begin), std::move(lists)};
}

/// The cliques that each variable is in.
class CliquesOf {
 public:
  CliquesOf(std::size_t variables, const Cliques& cliques) : begin_(variables + 1, 0) {
    for_each_slot(cliques, [&](std::size_t v, std::uint32_t) { ++begin_[v + 1]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    cliques_.resize(static_cast<std::size_t>(begin_.back()));
    std::vector<std::int64_t> next(begin_.begin(), begin_.end() - 1);
    for_each_slot(cliques,
                  [&](std::size_t v, std::uint32_t clique) { cliques_[static_cast<std::size_t>(next[v]++)] = clique; });
  }
  std::span<const std::uint32_t> operator[](Index variable) const {
    const auto v = static_cast<std::size_t>(variable);
    return {cliques_.data() + begin_[v], cliques_.data() + begin_[v + 1]};
  }

 private:
  template <typename F>
  static void for_each_slot(const Cliques& cliques, F&& f) {
    for (std::uint32_t c = 0; c < cliques.size(); ++c) {
      for (const Index v : cliques[c]) {
        if (v != kConstant) f(static_cast<std::size_t>(v), c);
      }
    }
  }

  std::vector<std::int64_t> begin_;
  std::vector<std::uint32_t> cliques_;
};

}  // namespace

NormalEquations::NormalEquations(std::vector<int> dofs, Cliques cliques, std::unique_ptr<SparseSolver> solver,
                                 const Ordering& ordering)
    : dofs_(std::move(dofs)), cliques_(std::move(cliques)), solver_(std::move(solver)) {
  offsets_.assign(dofs_.size() + 1, 0);
  for (std::size_t v = 0; v < dofs_.size(); ++v) offsets_[v + 1] = offsets_[v] + dofs_[v];
  gradient_.setZero(size());
  order_and_lay_out(ordering);
  if (!solver_) return;
  parallel_invoke(
      [&] {
        find_destinations();
        share_out_cliques();
        colour_large_cliques();
      },
      [&] {
        if (size() > 0) solver_->analyse(matrix_);
      });
}

template <typename F>
void NormalEquations::for_each_neighbour(Index v, std::span<const std::uint32_t> cliques, F&& f) const {
  for (const std::uint32_t clique : cliques) {
    for (const Index other : cliques_[clique]) {
      if (other != kConstant && other != v) f(other);
    }
  }
}

void NormalEquations::order_and_lay_out(const Ordering& ordering) {
  const CliquesOf cliques_of(dofs_.size(), cliques_);
  auto [begin, neighbours] = sorted_lists(dofs_.size(), [&](std::size_t k, std::vector<Index>& found) {
    const auto v = static_cast<Index>(k);
    for_each_neighbour(v, cliques_of[v], [&](Index other) { found.push_back(other); });
  });
  order_ = elimination_order({std::move(begin), std::move(neighbours)}, ordering);
  place_ = inverse_order(order_);
  matrix_.offsets.assign(order_.size() + 1, 0);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    matrix_.offsets[k + 1] = matrix_.offsets[k] + dofs_[static_cast<std::size_t>(order_[k])];
  }
  std::tie(matrix_.begin, matrix_.rows) = sorted_lists(order_.size(), [&](std::size_t k, std::vector<Index>& found) {
    const auto column = static_cast<Index>(k);
    found.push_back(column);
    for_each_neighbour(order_[k], cliques_of[order_[k]], [&](Index other) {
      if (place(other) > column) found.push_back(place(other));
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

Eigen::MatrixXd NormalEquations::unpermuted(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd out(columns.rows(), columns.cols());
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto variable = static_cast<std::size_t>(order_[k]);
    out.middleRows(offsets_[variable], dofs_[variable]) = columns.middleRows(matrix_.offsets[k], dofs_[variable]);
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
  if (!cholesky.factorise(H_free).empty()) return std::nullopt;
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
  const auto singular = solver_->factorise(matrix_);
  if (damping > 0.0) set_diagonal(undamped);
  if (singular.empty()) return std::nullopt;
  const auto place =
      std::upper_bound(matrix_.offsets.begin(), matrix_.offsets.end(), singular.front()) - matrix_.offsets.begin() - 1;
  return order_[static_cast<std::size_t>(place)];
}

Eigen::MatrixXd NormalEquations::null_space(std::size_t most_count) const {
  if (size() == 0) return {};
  SparseCholesky cholesky;
  cholesky.analyse(matrix_);
  auto singular = cholesky.factorise(matrix_);
  singular.resize(std::min(singular.size(), most_count));
  return unpermuted(cholesky.null_space(singular));
}

Eigen::MatrixXd NormalEquations::solve_columns(const Eigen::MatrixXd& B) const {
  return size() == 0 ? B : unpermuted(solver_->solve_columns(permuted(B)));
}

}  // namespace mapjoin
